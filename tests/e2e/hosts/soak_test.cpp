// Chaos: evolutions over workers on several hosts (over the loopback interface where there can be none), with faults
// of every kind at random moments, all from one seed that is printed. Each evolution must end with the serial result,
// bit for bit. A short one is part of the suite; tests/e2e/soak runs it for as long as one likes.
#include <cstdlib>
#include <functional>
#include <iomanip>
#include <iostream>
#include <map>
#include <signal.h>

#include "tests/e2e/hosts/soak_site.hpp"

namespace coppice::e2e {
namespace {

using namespace std::chrono_literals;

constexpr double kMinutesBetweenLines = 0.5;

double minutes_asked() {
  const char* text = std::getenv("COPPICE_SOAK_MINUTES");
  return text != nullptr ? std::strtod(text, nullptr) : 0.2;
}

std::uint32_t seed_asked() {
  const char* text = std::getenv("COPPICE_SOAK_SEED");
  return text != nullptr ? static_cast<std::uint32_t>(std::strtoul(text, nullptr, 10)) : std::random_device{}();
}

class Soak : public SoakSite {
 protected:
  void SetUp() override {
    SoakSite::SetUp();
    list_faults();
    keep_only_those_asked_for();
  }

  // Each ends before the next begins, but for strangers and datagrams; nothing is away for good.
  void list_faults() {
    faults_ = {
        {"worker killed", [this] { replace_worker(SIGKILL); }},
        {"worker killed young",
         [this] {
           add_worker();
           pass_up_to(150ms);  // it looks for the coordinator, or receives the chain
           workers_.back()->signal(SIGKILL);
           workers_.back()->wait();
           remove_worker(workers_.size() - 1);
         }},
        {"worker left", [this] { replace_worker(SIGTERM); }},
        {"worker stopped",
         [this] {
           Process& worker = *workers_[below(workers_.size())];
           worker.signal(SIGSTOP);
           pass_up_to(4s);  // its lease is 1.5 s
           worker.signal(SIGCONT);
         }},
        {"worker added", [this] { workers_.size() < kMostWorkers ? add_worker() : replace_worker(SIGTERM); }},
        {"all workers killed",
         [this] {
           workers_.clear();
           doors_.clear();
           pass_up_to(2s);
           fill_up();
         }},
        {"coordinator killed", [this] { end_coordinator(SIGKILL); }},
        {"coordinator asked to stop", [this] { end_coordinator(SIGINT); }},
        {"certificates rotated",
         [this] {
           if (secured_) {
             rotate_certificates();
           }
         }},
        {"coordinator requeued", [this] { hosts_ ? requeue_coordinator() : end_coordinator(SIGKILL); }},
        {"stranger",
         [this] {
           let_in(COPPICE_STRANGER, {domain_, "knock"});
         }},
        {"wrong version",
         [this] {
           let_in(COPPICE_STRANGER, {domain_, "next"});
         }},
        // Where not everything is checked, only one that lies from the start is sure to be found out in time.
        {"liar",
         [this] {
           let_in(COPPICE_LIAR, {domain_, all_checked_ ? std::to_string(below(200)) : "0"});
         }},
        {"datagrams",
         [this] {
           const std::string port = std::to_string(7410 + 250 * std::stoi(domain_));
           let_in(COPPICE_PELT, {std::to_string(random_()), std::to_string(1 + below(5)),
                                 address(coordinator_host_) + ":" + port, doors_[below(doors_.size())]});
         }},
    };
    if (has_clocks_) {
      faults_.emplace_back("clocks jump",
                           [this] { write("clock", (below(2) == 0 ? "+" : "-") + std::to_string(below(100'000))); });
    }
    if (mounted_) {
      faults_.emplace_back("disk full", [this] { fill_disk_for_a_while(); });
    }
    if (hosts_) {
      faults_.emplace_back("link down", [this] {
        const std::size_t host = 1 + below(kHosts);
        hosts_->set_link(host, false);
        pass_up_to(5s);
        hosts_->set_link(host, true);
      });
      faults_.emplace_back("packets lost", [this] {
        hosts_->lose(static_cast<int>(1 + below(20)));
        pass_up_to(3s);
        hosts_->lose(0);
      });
      faults_.emplace_back("link slow", [this] {
        const std::size_t host = some_host();
        hosts_->delay(host, static_cast<int>(1 + below(20)));
        pass_up_to(3s);
        hosts_->hasten(host);
      });
    }
  }

  // Some only, to look for what they do together.
  void keep_only_those_asked_for() {
    const char* const asked = std::getenv("COPPICE_SOAK_ONLY");  // names with commas between
    if (asked == nullptr) {
      return;
    }
    std::erase_if(faults_, [&](const auto& fault) {
      return ("," + std::string(asked) + ",").find("," + fault.first + ",") == std::string::npos;
    });
    ASSERT_FALSE(faults_.empty()) << "no fault is named " << asked;
  }

  void choose_chain() {
    const std::size_t chain = below(chains_.size());
    counts_["another chain held"] += chain != chain_ && !workers_.empty() ? 1 : 0;
    chain_ = chain;
    write("study.coppice", chains_[chain_]);
    std::filesystem::remove(path("serial.coppice"));
  }

  void evolve_under_fire(int evolution) {
    begin_logs(evolution);
    std::vector<std::string> settings = {
        "--seed", std::to_string(1 + below(1000)), "--set", "ga.generations=600", "--set", "ga.population=60"};
    if (below(2) == 0) {  // bred where they are evaluated, in epochs short enough to be many
      ++counts_["in demes"];
      for (const std::string& setting :
           {"ga.demes=" + std::to_string(2 + below(5)), "ga.epoch=" + std::to_string(2 + below(20)),
            std::string(below(2) == 0 ? "ga.migration=ring" : "ga.migration=random")}) {
        settings.insert(settings.end(), {"--set", setting});
      }
    }
    all_checked_ = below(2) == 0;
    choose_chain();
    choose_security();
    counts_["secured"] += secured_ ? 1 : 0;
    const auto expected = serial_runs(settings);
    for (const char* left : {"", "-wal", "-shm"}) {  // a coordinator killed at its very end leaves them to the next
      std::filesystem::remove(path(std::string("disk/study.coppice") + left));
    }
    write("disk/study.coppice", chains_[chain_]);
    fill_up();
    coordinate(settings);
    coordinator_->await_error("evolve: ");  // the run is in the study: it can be resumed
    disk_was_full_ = false;
    while (coordinator_->running() || resumed_after_full_disk()) {
      pass_up_to(700ms);
      if (coordinator_->running()) {
        const auto& [name, happen] = faults_[below(faults_.size())];
        ++counts_[name];
        history_ += name + "; ";
        happen();
      }
    }
    const Ending ending = coordinator_->wait();
    SCOPED_TRACE("seed " + settings[1] + ", chain " + std::to_string(chain_) + (all_checked_ ? ", all checked" : "") +
                 (secured_ ? ", secured" : ""));
    ASSERT_EQ(status(), "finished") << "ended with exit code " << ending.exit_code.value_or(-1) << ", signal "
                                    << ending.signal;
    expect_same_runs("disk/study.coppice", expected);
    strangers_.clear();
    for (const auto& worker : workers_) {
      EXPECT_TRUE(worker->running()) << "a worker ended with exit code " << worker->wait().exit_code.value_or(-1)
                                     << ", signal " << worker->wait().signal;
    }
  }

  void print_counts(int evolutions, double minutes) const {
    std::cout << std::fixed << std::setprecision(1) << minutes << " min: " << evolutions
              << " evolutions, each with the serial result; faults:";
    for (const auto& [fault, count] : counts_) {
      std::cout << ' ' << fault << ' ' << count << ';';
    }
    std::cout << std::endl;
  }

  std::size_t chain_ = 0;
  std::vector<std::pair<std::string, std::function<void()>>> faults_;
  std::map<std::string, int> counts_;
};

TEST_F(Soak, EveryEvolutionEndsWithTheSerialResultWhateverHappens) {
  const std::uint32_t seed = seed_asked();
  const auto begin = std::chrono::steady_clock::now();
  const auto minutes = [&] {
    return std::chrono::duration<double, std::ratio<60>>(std::chrono::steady_clock::now() - begin).count();
  };
  std::cout << "soak of " << minutes_asked() << " minutes, seed " << seed
            << (hosts_ ? ", on several hosts" : ", on one host")
            << (all_secured_ ? ", under DDS Security" : ", under DDS Security at times") << std::endl;
  random_.seed(seed);
  double next_line = 0.0;
  for (int evolutions = 1; minutes() < minutes_asked() && !HasFailure(); ++evolutions) {
    evolve_under_fire(evolutions);
    if (HasFailure()) {
      std::cout << all_logs() << std::endl;
    }
    end_logs(!HasFailure());
    if (!HasFailure() && (minutes() >= next_line || minutes() >= minutes_asked())) {
      next_line = minutes() + kMinutesBetweenLines;
      print_counts(evolutions, minutes());
    }
  }
}

}  // namespace
}  // namespace coppice::e2e
