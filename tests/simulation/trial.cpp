#include "tests/simulation/trial.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <exception>
#include <fmt/format.h>
#include <malloc.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/simulation/dice.hpp"

namespace coppice::simulation {

std::optional<Finding> run_here(const Scenario& scenario, Report* report) {
  try {
    const Report first = World(scenario).run();
    if (report != nullptr) {
      *report = first;
    }
    if (hash(scenario.seed, 20) % 20 == 0) {
      const Report second = World(scenario).run();
      if (second.actions_hash != first.actions_hash || second.steps != first.steps) {
        return Finding{"same", "two runs of one seed differ"};
      }
    }
    return std::nullopt;
  } catch (const Broken& broken) {
    return Finding{broken.name(), broken.what()};
  } catch (const std::exception& error) {
    return Finding{"throws", error.what()};
  }
}

std::optional<Finding> run_apart(const Scenario& scenario) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) {
    return Finding{"pipe", "no pipe"};
  }
  const pid_t child = fork();
  if (child == 0) {
    close(ends[0]);
    const auto finding = run_here(scenario);
    const std::string text = finding ? finding->name + "\n" + finding->how : "";
    static_cast<void>(!write(ends[1], text.data(), text.size()));
    _exit(0);
  }
  close(ends[1]);
  std::string text;
  std::array<char, 4096> some;
  for (ssize_t count = 0; (count = read(ends[0], some.data(), some.size())) > 0 || (count < 0 && errno == EINTR);) {
    text.append(some.data(), static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
  }
  close(ends[0]);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFSIGNALED(status)) {
    return Finding{"ended", fmt::format("the process ended by signal {}", WTERMSIG(status))};
  }
  if (text.empty()) {
    return std::nullopt;
  }
  const std::size_t end = text.find('\n');
  return Finding{text.substr(0, end), text.substr(end + 1)};
}

std::size_t bytes_of_a_worker(std::uint32_t workers) {
  using Time = Dispatcher::Time;
  DispatchSettings settings;
  settings.protocol = World::kProtocol;
  Dispatcher dispatcher(settings);
  const std::size_t before = mallinfo2().uordblks;
  std::vector<DispatchEvent> events;
  for (std::uint64_t i = 1; i <= workers; ++i) {
    HelloHeard hello;
    hello.worker = WorkerId{hash(i) | 1U};
    hello.origin = Origin{static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i >> 8U)};
    hello.name = "a-host-of-a-usual-name.example.org, pid 1234567";
    hello.version = "1.0.0";
    hello.protocol = World::kProtocol;
    hello.serves = hello.holds_chain = true;
    events.emplace_back(std::move(hello));
    events.emplace_back(LinkChanged{WorkerId{hash(i) | 1U}, true});
  }
  const RequestId request = dispatcher.open({.work = {}, .most_per_batch = 1, .expected = 2 * workers}, Time{});
  dispatcher.add(request, 2 * workers);
  dispatcher.seal(request);
  dispatcher.step(events, Time{});
  events = {};
  return (mallinfo2().uordblks - before) / workers;
}

namespace {

class Shrinking {
 public:
  Shrinking(Scenario scenario, const Finding& finding, int most)
      : best_(std::move(scenario)), finding_(finding), left_(most) {}

  Scenario run() {
    for (bool smaller = true; smaller && left_ > 0;) {
      smaller = fewer_faults();
      smaller = none(&Scenario::guests) || smaller;
      smaller = none(&Scenario::demes) || smaller;
      smaller = fewer(&Scenario::requests) || smaller;
      smaller = fewer(&Scenario::clients) || smaller;
      smaller = fewer(&Scenario::units) || smaller;
      smaller = fewer(&Scenario::workers) || smaller;
    }
    return best_;
  }

 private:
  bool accept(const Scenario& candidate) {
    if (left_-- <= 0) {
      return false;
    }
    const auto finding = run_apart(candidate);
    if (!finding || finding->name != finding_.name) {
      return false;
    }
    best_ = candidate;
    return true;
  }

  // Zeller & Hildebrandt's ddmin: halves, then quarters, ..., then single records are left out.
  bool fewer_faults() {
    bool smaller = false;
    for (std::size_t size = std::max<std::size_t>(best_.faults.size() / 2, 1); !best_.faults.empty(); size /= 2) {
      for (std::size_t begin = 0; begin < best_.faults.size();) {
        Scenario candidate = best_;
        const auto first = candidate.faults.begin() + static_cast<std::ptrdiff_t>(begin);
        candidate.faults.erase(first, first + static_cast<std::ptrdiff_t>(std::min(size, best_.faults.size() - begin)));
        if (accept(candidate)) {
          smaller = true;
        } else {
          begin += size;
        }
      }
      if (size <= 1) {
        break;
      }
    }
    return smaller;
  }

  bool none(std::uint32_t Scenario::*field) {
    Scenario candidate = best_;
    candidate.*field = 0;
    return best_.*field > 0 && (accept(candidate) || fewer(field));
  }

  bool fewer(std::uint32_t Scenario::*field) {
    bool smaller = false;
    for (std::uint32_t step = best_.*field / 2; step > 0;) {
      Scenario candidate = best_;
      if (candidate.*field > step) {
        candidate.*field -= step;
        if (accept(candidate)) {
          smaller = true;
          step = std::min(step, best_.*field / 2);
          continue;
        }
      }
      step /= 2;
    }
    return smaller;
  }

  Scenario best_;
  Finding finding_;
  int left_;
};

}  // namespace

Scenario shrunk(Scenario scenario, const Finding& finding, int most) {
  return Shrinking(std::move(scenario), finding, most).run();
}

}  // namespace coppice::simulation
