#include "common/metrics/outlet.hpp"

#include <arpa/inet.h>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <microhttpd.h>
#include <mutex>
#include <netdb.h>
#include <netinet/in.h>
#include <spdlog/spdlog.h>
#include <string_view>
#include <sys/socket.h>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>

namespace coppice {
namespace {

constexpr std::chrono::seconds kWriteInterval{5};  // node exporters are asked every 15 s and more
constexpr unsigned kMostConnections = 16;
constexpr unsigned kSilence = 10;  // seconds, after which a connection is closed
constexpr std::size_t kConnectionMemory = 8192;
constexpr int kPatience = 5;  // seconds, for a health check
constexpr const char* kTextFormat = "text/plain; version=0.0.4; charset=utf-8";

using Addresses = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

Addresses numeric(const MetricsPlace& place) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(place.address.c_str(), std::to_string(place.port).c_str(), &hints, &found);
  return {error == 0 ? found : nullptr, &freeaddrinfo};
}

std::string reason() { return std::generic_category().message(errno); }

MHD_Result respond(MHD_Connection* connection, unsigned status, const std::string& body, const char* type) {
  MHD_Response* const response = MHD_create_response_from_buffer(body.size(), const_cast<char*>(body.data()),
                                                                 MHD_RESPMEM_MUST_COPY);  // NOLINT: copied
  if (response == nullptr) {
    return MHD_NO;
  }
  MHD_add_response_header(response, MHD_HTTP_HEADER_CONTENT_TYPE, type);
  const MHD_Result queued = MHD_queue_response(connection, status, response);
  MHD_destroy_response(response);
  return queued;
}

MHD_Result answer(void* cls, MHD_Connection* connection, const char* url, const char* method, const char* /*version*/,
                  const char* /*data*/, std::size_t* bytes, void** state) {
  const auto& source = *static_cast<const MetricsOutlet::Source*>(cls);
  if (*state == nullptr) {  // the headers; what was asked is answered on the next call
    *state = connection;
    return MHD_YES;
  }
  if (*bytes > 0) {  // a body: nobody needs one
    return MHD_NO;
  }
  const std::string_view path = url;
  if (std::string_view(method) != MHD_HTTP_METHOD_GET && std::string_view(method) != MHD_HTTP_METHOD_HEAD) {
    return respond(connection, MHD_HTTP_METHOD_NOT_ALLOWED, "only GET\n", "text/plain");
  }
  if (path == "/metrics") {
    return respond(connection, MHD_HTTP_OK, source.text(), kTextFormat);
  }
  if (source.health && (path == "/health" || path == "/ready")) {
    const Health health = source.health();
    return respond(connection,
                   (path == "/ready" ? health.ready : health.alive) ? MHD_HTTP_OK : MHD_HTTP_SERVICE_UNAVAILABLE,
                   health.words + "\n", "text/plain");
  }
  return respond(connection, MHD_HTTP_NOT_FOUND,
                 source.health ? "expected /metrics, /health or /ready\n" : "expected /metrics\n", "text/plain");
}

// Whole or not at all, and for everybody to read, whatever the umask: the node exporter is another user.
Result<void> write_readable(const std::string& path, const std::string& text) {
  const std::string next = fmt::format("{}.{}", path, getpid());
  const auto refuse = [&] {
    auto error = bad_input(fmt::format("--metrics-file: cannot write {}: {}", path, reason()));
    unlink(next.c_str());
    return error;
  };
  const int file = open(next.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, S_IRUSR | S_IWUSR);
  if (file < 0) {
    return refuse();
  }
  const bool written = write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size()) &&
                       fchmod(file, S_IRUSR | S_IWUSR | S_IRGRP | S_IROTH) == 0;
  const int error = written ? 0 : errno != 0 ? errno : ENOSPC;
  close(file);
  errno = error;
  if (!written || std::rename(next.c_str(), path.c_str()) != 0) {
    return refuse();
  }
  return {};
}

class Outlet : public MetricsOutlet {
 public:
  Outlet(const MetricsTargets& targets, Source source) : file_(targets.file), source_(std::move(source)) {}
  Outlet(const Outlet&) = delete;
  Outlet& operator=(const Outlet&) = delete;
  ~Outlet() override {
    if (thread_.joinable()) {
      {
        const std::lock_guard lock(mutex_);
        ending_ = true;
      }
      ends_.notify_all();
      thread_.join();
    }
    if (daemon_ != nullptr) {
      MHD_stop_daemon(daemon_);
    }
  }

  Result<void> listen(const std::string& text) {
    const auto place = metrics_place("--metrics", text);
    if (!place) {
      return tl::unexpected(place.error());
    }
    const Addresses address = numeric(*place);
    errno = 0;
    daemon_ = MHD_start_daemon(static_cast<unsigned>(MHD_USE_AUTO_INTERNAL_THREAD) |
                                   (address->ai_family == AF_INET6 ? static_cast<unsigned>(MHD_USE_IPv6) : 0U),
                               place->port, nullptr, nullptr, &answer, &source_, MHD_OPTION_SOCK_ADDR, address->ai_addr,
                               MHD_OPTION_CONNECTION_LIMIT, kMostConnections, MHD_OPTION_CONNECTION_TIMEOUT, kSilence,
                               MHD_OPTION_CONNECTION_MEMORY_LIMIT, kConnectionMemory, MHD_OPTION_END);
    if (daemon_ == nullptr) {
      return bad_input(fmt::format("--metrics {}: cannot listen there: {}", text,
                                   errno != 0 ? reason() : std::string("the system refused")));
    }
    const MHD_DaemonInfo* const bound = MHD_get_daemon_info(daemon_, MHD_DAEMON_INFO_BIND_PORT);
    port_ = bound != nullptr ? bound->port : place->port;
    return {};
  }

  Result<void> begin_file() {
    if (auto written = write_readable(file_, source_.text()); !written) {
      return written;
    }
    thread_ = std::thread([this] { keep_file(); });
    return {};
  }

  std::uint16_t port() const override { return port_; }

 private:
  void keep_file() {
    bool complained = false;
    std::unique_lock lock(mutex_);
    while (!ending_) {
      ends_.wait_for(lock, kWriteInterval, [this] { return ending_; });
      lock.unlock();
      const auto written = write_readable(file_, source_.text());
      if (!written && !complained) {
        spdlog::warn("{} (tried again every {} s)", written.error().message, kWriteInterval.count());
      }
      complained = !written;
      lock.lock();
    }
  }

  std::string file_;
  Source source_;
  MHD_Daemon* daemon_ = nullptr;
  std::uint16_t port_ = 0;
  std::mutex mutex_;
  std::condition_variable ends_;
  bool ending_ = false;
  std::thread thread_;
};

}  // namespace

Result<MetricsPlace> metrics_place(const std::string& flag, const std::string& text) {
  MetricsPlace place;
  const std::size_t colon = text.rfind(':');
  const std::string port = colon == std::string::npos ? text : text.substr(colon + 1);
  if (colon != std::string::npos) {
    place.address = text.substr(0, colon);
    if (place.address.size() >= 2 && place.address.front() == '[' && place.address.back() == ']') {
      place.address = place.address.substr(1, place.address.size() - 2);
    }
  }
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), place.port);
  if (error != std::errc{} || end != port.data() + port.size() || numeric(place) == nullptr) {
    return bad_input(
        fmt::format("{} {}: expected PORT or ADDRESS:PORT with an address in numbers, as 9470, "
                    "0.0.0.0:9470 or [::1]:9470",
                    flag, text));
  }
  return place;
}

Result<std::unique_ptr<MetricsOutlet>> MetricsOutlet::open(const MetricsTargets& targets, Source source) {
  auto outlet = std::make_unique<Outlet>(targets, std::move(source));
  if (!targets.place.empty()) {
    if (auto listening = outlet->listen(targets.place); !listening) {
      return tl::unexpected(listening.error());
    }
  }
  if (!targets.file.empty()) {
    if (auto begun = outlet->begin_file(); !begun) {
      return tl::unexpected(begun.error());
    }
  }
  return std::unique_ptr<MetricsOutlet>(std::move(outlet));
}

Result<std::string> ask_health(const std::string& flag, const std::string& place, const std::string& path) {
  const auto where = metrics_place(flag, place);
  if (!where) {
    return tl::unexpected(where.error());
  }
  const Addresses address = numeric(*where);
  const int connection = socket(address->ai_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const timeval patience{.tv_sec = kPatience, .tv_usec = 0};
  setsockopt(connection, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  setsockopt(connection, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
  const std::string request = fmt::format("GET {} HTTP/1.0\r\n\r\n", path);
  std::string response;
  bool asked = connection >= 0 && connect(connection, address->ai_addr, address->ai_addrlen) == 0 &&
               send(connection, request.data(), request.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(request.size());
  for (char buffer[512]; asked;) {
    const ssize_t count = recv(connection, buffer, sizeof buffer, 0);
    asked = count >= 0;
    if (count <= 0) {
      break;
    }
    response.append(buffer, static_cast<std::size_t>(count));
  }
  const std::string why = reason();
  if (connection >= 0) {
    close(connection);
  }
  if (!asked) {
    return failed(fmt::format("{} {}: no answer: {}", flag, place, why));
  }
  const std::size_t head = response.find("\r\n\r\n");
  if (response.rfind("HTTP/1.", 0) != 0 || head == std::string::npos) {
    return failed(fmt::format("{} {}: what answers there is no program of ours", flag, place));
  }
  std::string line = response.substr(head + 4);
  while (!line.empty() && line.back() == '\n') {
    line.pop_back();
  }
  constexpr std::size_t kStatusAt = sizeof("HTTP/1.1 ") - 1;
  return response.compare(kStatusAt, 3, "200") == 0 ? Result<std::string>(line) : failed(line);
}

}  // namespace coppice
