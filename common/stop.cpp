#include "common/stop.hpp"

#include <array>
#include <cerrno>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <string_view>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <system_error>
#include <unistd.h>
#include <utility>

namespace coppice {
namespace {

constexpr int kExitBySecondSignal = 130;

sigset_t stop_signals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  return set;
}

int checked_descriptor(int descriptor, const char* what) {
  if (descriptor < 0) {
    throw std::system_error(errno, std::generic_category(), what);
  }
  return descriptor;
}

}  // namespace

StopFlag::Wake::Wake(Wake&& other) noexcept : flag_(std::exchange(other.flag_, nullptr)), key_(other.key_) {}

StopFlag::Wake& StopFlag::Wake::operator=(Wake&& other) noexcept {
  std::swap(flag_, other.flag_);
  std::swap(key_, other.key_);
  return *this;
}

StopFlag::Wake::~Wake() {
  if (flag_ != nullptr) {
    const std::lock_guard lock(flag_->mutex_);
    flag_->wakes_.erase(key_);
  }
}

void StopFlag::raise() {
  const std::lock_guard lock(mutex_);
  if (raised_.exchange(true, std::memory_order_acq_rel)) {
    return;
  }
  for (const auto& [key, wake] : wakes_) {
    wake();
  }
}

StopFlag::Wake StopFlag::on_raise(std::function<void()> wake) const {
  const std::lock_guard lock(mutex_);
  if (raised()) {
    wake();
  }
  const std::uint64_t key = next_key_++;
  wakes_.emplace(key, std::move(wake));
  return {*this, key};
}

void block_stop_signals() {
  const sigset_t set = stop_signals();
  if (const int error = pthread_sigmask(SIG_BLOCK, &set, nullptr); error != 0) {
    throw std::system_error(error, std::generic_category(), "cannot block SIGINT and SIGTERM");
  }
}

StopOnSignals::StopOnSignals(StopFlag& flag) {
  const sigset_t set = stop_signals();
  signals_ = checked_descriptor(signalfd(-1, &set, SFD_CLOEXEC), "cannot wait for signals");
  leave_ = checked_descriptor(eventfd(0, EFD_CLOEXEC), "cannot wait for signals");
  thread_ = std::thread([this, &flag] { wait_for_signals(flag); });
}

StopOnSignals::~StopOnSignals() {
  const std::uint64_t one = 1;
  ssize_t written = 0;
  do {
    written = write(leave_, &one, sizeof one);
  } while (written < 0 && errno == EINTR);
  thread_.join();
  close(leave_);
  close(signals_);
}

void StopOnSignals::wait_for_signals(StopFlag& flag) const {
  std::array<pollfd, 2> sources = {{{signals_, POLLIN, 0}, {leave_, POLLIN, 0}}};
  // Ends with the process (second signal) or with this object.
  while (true) {
    if (poll(sources.data(), sources.size(), -1) < 0) {
      continue;  // EINTR: a debugger was attached
    }
    if ((sources[1].revents & POLLIN) != 0) {
      return;
    }
    signalfd_siginfo info{};
    if (read(signals_, &info, sizeof info) != static_cast<ssize_t>(sizeof info)) {
      continue;
    }
    if (flag.raised()) {
      _exit(kExitBySecondSignal);
    }
    if (info.ssi_signo == SIGINT) {
      constexpr std::string_view kHint = "\ncoppice: stopping; press Ctrl-C again to end at once\n";
      [[maybe_unused]] const ssize_t shown = write(STDERR_FILENO, kHint.data(), kHint.size());
    }
    flag.raise();
  }
}

}  // namespace coppice
