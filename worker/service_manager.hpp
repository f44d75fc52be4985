// Tells systemd how a worker does (sd_notify(3)): a datagram of lines to the socket that NOTIFY_SOCKET names. Does
// nothing where no service manager asked for it.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <sys/un.h>

namespace coppice {

class ServiceManager {
 public:
  // As the environment says; takes the variables out of it, so that no child thinks that they are meant for it.
  static ServiceManager from_environment();

  // None: tells nobody.
  ServiceManager() = default;
  ServiceManager(ServiceManager&& other) noexcept;
  ServiceManager& operator=(ServiceManager&& other) noexcept;
  ServiceManager(const ServiceManager&) = delete;
  ServiceManager& operator=(const ServiceManager&) = delete;
  ~ServiceManager();

  bool listens() const { return socket_ >= 0; }
  void ready();
  void status(const std::string& words);
  void stopping();
  // Still alive: to be called often, says so as often as WATCHDOG_USEC wants it.
  void alive();

 private:
  void tell(const std::string& lines) const;

  int socket_ = -1;
  sockaddr_un address_{};
  std::uint32_t length_ = 0;
  std::optional<std::chrono::microseconds> interval_;
  std::chrono::steady_clock::time_point next_{};
};

}  // namespace coppice
