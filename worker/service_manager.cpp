#include "worker/service_manager.hpp"

#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <sys/socket.h>
#include <unistd.h>
#include <utility>

namespace coppice {

ServiceManager ServiceManager::from_environment() {
  ServiceManager manager;
  const char* const place = std::getenv("NOTIFY_SOCKET");
  const std::string_view path = place != nullptr ? place : "";
  const bool usable =
      path.size() > 1 && path.size() < sizeof manager.address_.sun_path && (path.front() == '/' || path.front() == '@');
  if (usable) {
    manager.address_.sun_family = AF_UNIX;
    std::memcpy(manager.address_.sun_path, path.data(), path.size());
    if (path.front() == '@') {
      manager.address_.sun_path[0] = '\0';  // abstract: its name begins with a zero byte
    }
    manager.length_ = static_cast<std::uint32_t>(offsetof(sockaddr_un, sun_path) + path.size());
    manager.socket_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    const char* const pid = std::getenv("WATCHDOG_PID");
    const char* const limit = std::getenv("WATCHDOG_USEC");
    if (limit != nullptr && (pid == nullptr || std::strtol(pid, nullptr, 10) == getpid())) {
      const std::int64_t microseconds = std::strtoll(limit, nullptr, 10);
      if (microseconds > 0) {
        manager.interval_ = std::chrono::microseconds(microseconds / 3);  // half would do; a busy machine is late
      }
    }
  }
  for (const char* const name : {"NOTIFY_SOCKET", "WATCHDOG_PID", "WATCHDOG_USEC"}) {
    unsetenv(name);
  }
  return manager;
}

ServiceManager::ServiceManager(ServiceManager&& other) noexcept { *this = std::move(other); }

ServiceManager& ServiceManager::operator=(ServiceManager&& other) noexcept {
  std::swap(socket_, other.socket_);
  std::swap(address_, other.address_);
  std::swap(length_, other.length_);
  std::swap(interval_, other.interval_);
  std::swap(next_, other.next_);
  return *this;
}

ServiceManager::~ServiceManager() {
  if (socket_ >= 0) {
    close(socket_);
  }
}

void ServiceManager::ready() { tell("READY=1"); }

void ServiceManager::status(const std::string& words) { tell("STATUS=" + words); }

void ServiceManager::stopping() { tell("STOPPING=1"); }

void ServiceManager::alive() {
  const auto now = std::chrono::steady_clock::now();
  if (interval_ && now >= next_) {
    next_ = now + *interval_;
    tell("WATCHDOG=1");
  }
}

// A manager that does not listen just now asks for nothing.
void ServiceManager::tell(const std::string& lines) const {
  if (socket_ >= 0) {
    static_cast<void>(sendto(socket_, lines.data(), lines.size(), MSG_NOSIGNAL | MSG_DONTWAIT,
                             reinterpret_cast<const sockaddr*>(&address_), length_));
  }
}

}  // namespace coppice
