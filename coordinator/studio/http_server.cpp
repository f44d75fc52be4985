#include "coordinator/studio/http_server.hpp"

#include <algorithm>
#include <arpa/inet.h>
#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fmt/format.h>
#include <microhttpd.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <utility>

namespace coppice {
namespace {

constexpr unsigned kOtherFiles = 64;  // descriptors that the rest of the program needs

// One request while it comes in.
struct Incoming {
  HttpRequest request;
  bool too_large = false;
};

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

MHD_Result add_header(void* headers, MHD_ValueKind /*kind*/, const char* name, const char* value) {
  (*static_cast<std::map<std::string, std::string>*>(headers))[lower(name)] = value == nullptr ? "" : value;
  return MHD_YES;
}

MHD_Result add_argument(void* query, MHD_ValueKind /*kind*/, const char* name, const char* value) {
  (*static_cast<std::map<std::string, std::string>*>(query))[name] = value == nullptr ? "" : value;
  return MHD_YES;
}

MHD_Result send(MHD_Connection* connection, const HttpResponse& response) {
  MHD_Response* message =
      MHD_create_response_from_buffer(response.body.size(), const_cast<char*>(response.body.data()),  // NOLINT: copied
                                      MHD_RESPMEM_MUST_COPY);
  if (message == nullptr) {
    return MHD_NO;
  }
  MHD_add_response_header(message, MHD_HTTP_HEADER_CONTENT_TYPE, response.type.c_str());
  for (const auto& [name, value] : response.headers) {
    MHD_add_response_header(message, name.c_str(), value.c_str());
  }
  const MHD_Result queued = MHD_queue_response(connection, response.status, message);
  MHD_destroy_response(message);
  return queued;
}

HttpResponse too_large() {
  return {.status = MHD_HTTP_CONTENT_TOO_LARGE,
          .body = fmt::format(R"({{"error":"the body is too large: at most {} bytes"}})", kMostBody),
          .headers = {{"Connection", "close"}}};
}

// Nothing that is served has a name that needs escapes, so they stay as they are: what "%2e" or "%00" would become is
// never looked at.
std::size_t keep_escapes(void* /*cls*/, MHD_Connection* /*connection*/, char* text) { return std::strlen(text); }

bool announces_too_much(const HttpRequest& request) {
  const auto length = request.headers.find("content-length");
  if (length == request.headers.end()) {
    return false;
  }
  errno = 0;
  const unsigned long long bytes = std::strtoull(length->second.c_str(), nullptr, 10);
  return errno != 0 || bytes > kMostBody;
}

// Descriptors for this many connections, as far as the system gives them.
unsigned connections_allowed() {
  rlimit files{};
  if (getrlimit(RLIMIT_NOFILE, &files) != 0) {
    return kMostConnections / 4;
  }
  const rlim_t wanted = kMostConnections + kOtherFiles;
  if (files.rlim_cur < wanted) {
    files.rlim_cur = std::min<rlim_t>(wanted, files.rlim_max);
    static_cast<void>(setrlimit(RLIMIT_NOFILE, &files));
    getrlimit(RLIMIT_NOFILE, &files);
  }
  return static_cast<unsigned>(
      std::clamp<rlim_t>(files.rlim_cur > kOtherFiles ? files.rlim_cur - kOtherFiles : 1, 1, kMostConnections));
}

}  // namespace

struct HttpServer::State {
  HttpAnswer answer;
  MHD_Daemon* daemon = nullptr;
  std::uint16_t port = 0;

  ~State() {
    if (daemon != nullptr) {
      MHD_stop_daemon(daemon);
    }
  }

  HttpResponse answer_to(const HttpRequest& request) const {
    try {
      return answer(request);
    } catch (const std::exception& error) {
      return {.status = MHD_HTTP_INTERNAL_SERVER_ERROR,
              .body = R"({"error":"the studio met an internal error; the study is as it was"})"};
    }
  }

  // Called when the headers are there, again for every piece of the body, and at last with none.
  static MHD_Result handle(void* cls, MHD_Connection* connection, const char* url, const char* method,
                           const char* /*version*/, const char* data, std::size_t* size, void** context) {
    const auto* state = static_cast<const State*>(cls);
    if (*context == nullptr) {
      auto incoming = std::make_unique<Incoming>();
      incoming->request.method = method;
      incoming->request.path = url;
      MHD_get_connection_values(connection, MHD_HEADER_KIND, add_header, &incoming->request.headers);
      MHD_get_connection_values(connection, MHD_GET_ARGUMENT_KIND, add_argument, &incoming->request.query);
      const bool refused = announces_too_much(incoming->request);
      *context = incoming.release();  // forget() takes it
      return refused ? send(connection, too_large()) : MHD_YES;
    }
    auto* incoming = static_cast<Incoming*>(*context);
    if (*size > 0) {
      if (incoming->request.body.size() + *size > kMostBody) {
        return MHD_NO;  // an upload without an announced end: it is cut off
      }
      incoming->request.body.append(data, *size);
      *size = 0;
      return MHD_YES;
    }
    return send(connection, state->answer_to(incoming->request));
  }

  static void forget(void* /*cls*/, MHD_Connection* /*connection*/, void** context,
                     MHD_RequestTerminationCode /*why*/) {
    delete static_cast<Incoming*>(*context);  // NOLINT: a C library carried it
    *context = nullptr;
  }
};

HttpServer::HttpServer(std::unique_ptr<State> state) : state_(std::move(state)) {}
HttpServer::HttpServer(HttpServer&&) noexcept = default;
HttpServer& HttpServer::operator=(HttpServer&&) noexcept = default;
HttpServer::~HttpServer() = default;

std::uint16_t HttpServer::port() const { return state_->port; }

Result<HttpServer> HttpServer::start(std::uint16_t port, HttpAnswer answer) {
  auto state = std::make_unique<State>();
  state->answer = std::move(answer);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  errno = 0;
  state->daemon = MHD_start_daemon(
      MHD_USE_EPOLL_INTERNAL_THREAD, port, nullptr, nullptr, &State::handle, state.get(), MHD_OPTION_SOCK_ADDR,
      reinterpret_cast<sockaddr*>(&address),  // NOLINT: as the socket interface wants it
      MHD_OPTION_THREAD_POOL_SIZE, kServerThreads, MHD_OPTION_CONNECTION_LIMIT, connections_allowed(),
      MHD_OPTION_CONNECTION_TIMEOUT, static_cast<unsigned>(kSilence.count()), MHD_OPTION_CONNECTION_MEMORY_LIMIT,
      kConnectionMemory, MHD_OPTION_STRICT_FOR_CLIENT, 1, MHD_OPTION_UNESCAPE_CALLBACK, &keep_escapes, nullptr,
      MHD_OPTION_NOTIFY_COMPLETED, &State::forget, nullptr, MHD_OPTION_END);
  if (state->daemon == nullptr) {
    return failed(fmt::format("--port {}: cannot listen on 127.0.0.1: {}", port,
                              errno != 0 ? std::strerror(errno) : "the system refused"));
  }
  const MHD_DaemonInfo* bound = MHD_get_daemon_info(state->daemon, MHD_DAEMON_INFO_BIND_PORT);
  state->port = bound != nullptr ? bound->port : port;
  return HttpServer(std::move(state));
}

}  // namespace coppice
