#include "coordinator/fleet/local_workers.hpp"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <signal.h>
#include <sstream>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <utility>

#include "common/cores.hpp"
#include "coordinator/fleet/spawn.hpp"

namespace coppice {
namespace {

constexpr std::chrono::milliseconds kPatienceAtEnd{1500};
constexpr std::chrono::milliseconds kReapInterval{2};

std::string how_it_ended(int status) {
  if (WIFSIGNALED(status)) {
    return fmt::format("was killed by signal {}", WTERMSIG(status));
  }
  return fmt::format("exited with code {}", WEXITSTATUS(status));
}

}  // namespace

Result<pid_t> LocalWorkers::spawn(const Worker& worker) const {
  const std::string domain = std::to_string(domain_);
  const std::string threads = std::to_string(threads_);
  const std::string cores = fmt::format("{}", fmt::join(worker.cores, ","));
  const std::string parent = std::to_string(getpid());
  const std::string program = program_.string();
  std::vector<const char*> arguments = {program.c_str(), "--coordinator", "127.0.0.1",    "--domain",
                                        domain.c_str(),  "--parent",      parent.c_str(), "--log-level",
                                        "warn",          "--threads",     threads.c_str()};
  if (!worker.cores.empty()) {
    arguments.insert(arguments.end(), {"--cores", cores.c_str()});
  }
  for (const std::string& flag : worker.flags) {
    arguments.push_back(flag.c_str());
  }
  return spawn_in_own_group(std::move(arguments));
}

Result<void> LocalWorkers::check(const std::filesystem::path& program) {
  if (access(program.c_str(), X_OK) != 0) {
    return failed(fmt::format("cannot start {}: {}", program.string(), std::strerror(errno)));
  }
  return {};
}

Result<LocalWorkers> LocalWorkers::start(const std::filesystem::path& program, const std::vector<Flags>& flags,
                                         std::uint32_t domain, std::uint32_t threads) {
  LocalWorkers workers(program, domain, threads);
  const std::vector<int> cores = usable_cores();
  const bool fill_the_machine = flags.size() * threads == cores.size();
  for (std::size_t place = 0; place < flags.size(); ++place) {
    Worker worker{.flags = flags[place]};
    if (fill_the_machine) {
      const auto first = cores.begin() + static_cast<std::ptrdiff_t>(place * threads);
      worker.cores.assign(first, first + threads);
    }
    const auto pid = workers.spawn(worker);
    if (!pid) {
      return tl::unexpected(pid.error());
    }
    worker.pid = *pid;
    workers.workers_.push_back(std::move(worker));
  }
  return workers;
}

LocalWorkers::LocalWorkers(LocalWorkers&& other) noexcept
    : program_(std::move(other.program_)),
      domain_(other.domain_),
      threads_(other.threads_),
      workers_(std::move(other.workers_)) {
  other.workers_.clear();
}

LocalWorkers::~LocalWorkers() {
  for (const Worker& worker : workers_) {
    if (worker.pid != 0) {
      kill(worker.pid, SIGTERM);
      kill(worker.pid, SIGCONT);  // a stopped process takes no SIGTERM
    }
  }
  const auto end = std::chrono::steady_clock::now() + kPatienceAtEnd;
  for (Worker& worker : workers_) {
    while (worker.pid != 0) {
      const pid_t reaped = waitpid(worker.pid, nullptr, WNOHANG);
      if (reaped == worker.pid || (reaped < 0 && errno != EINTR)) {
        worker.pid = 0;
      } else if (std::chrono::steady_clock::now() > end) {
        kill(worker.pid, SIGKILL);
        waitpid(worker.pid, nullptr, 0);
        worker.pid = 0;
      } else {
        std::this_thread::sleep_for(kReapInterval);
      }
    }
  }
}

std::vector<LocalWorkers::Ended> LocalWorkers::reap() {
  std::vector<Ended> ended;
  for (std::size_t place = 0; place < workers_.size(); ++place) {
    Worker& worker = workers_[place];
    int status = 0;
    if (worker.pid == 0 || waitpid(worker.pid, &status, WNOHANG) != worker.pid) {
      continue;
    }
    ended.push_back({place, worker.pid, WIFEXITED(status) && WEXITSTATUS(status) == 0,
                     fmt::format("worker process {} {}", worker.pid, how_it_ended(status))});
    worker.pid = 0;
  }
  return ended;
}

Result<pid_t> LocalWorkers::start_again(std::size_t place) {
  Worker& worker = workers_.at(place);
  auto pid = spawn(worker);
  if (pid) {
    worker.pid = *pid;
  }
  return pid;
}

bool LocalWorkers::keeps_to(pid_t worker, int core) const {
  return std::ranges::any_of(workers_, [&](const Worker& local) {
    return local.pid == worker && std::ranges::find(local.cores, core) != local.cores.end();
  });
}

std::vector<pid_t> LocalWorkers::pids() const {
  std::vector<pid_t> pids;
  for (const Worker& worker : workers_) {
    if (worker.pid != 0) {
      pids.push_back(worker.pid);
    }
  }
  return pids;
}

Result<std::filesystem::path> find_worker_program() {
  constexpr const char* kName = "coppice-worker";
  std::vector<std::filesystem::path> places;
  std::error_code ignored;
  if (const auto self = std::filesystem::read_symlink("/proc/self/exe", ignored); !self.empty()) {
    places.push_back(self.parent_path());
  }
  if (const char* path = std::getenv("PATH"); path != nullptr) {
    std::istringstream directories(path);
    for (std::string directory; std::getline(directories, directory, ':');) {
      places.emplace_back(directory);
    }
  }
  for (const auto& place : places) {
    auto candidate = place / kName;
    if (access(candidate.c_str(), X_OK) == 0) {
      return candidate;
    }
  }
  return failed(fmt::format("no {} beside this program or in PATH: name it with --worker-program", kName));
}

}  // namespace coppice
