// A small HTTP/1.1 server for this machine alone: libmicrohttpd (GNU), which keeps any number of idle connections on
// a few threads and has its limits built in. Everything that comes from outside is bounded here: bytes of a header, of
// a body, connections, and how long a silent one is kept. Knows nothing of what is served.
//
// Thread rule: `answer` is called on several threads at once; the server outlives no call of it. Move-only.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "common/error.hpp"

namespace coppice {

inline constexpr std::size_t kMostBody = std::size_t{2} << 20U;           // bytes of a request's body
inline constexpr std::size_t kConnectionMemory = std::size_t{32} << 10U;  // bytes, of headers too
inline constexpr unsigned kMostConnections = 2048;                        // fewer where the system allows fewer files
inline constexpr unsigned kServerThreads = 4;
inline constexpr std::chrono::seconds kSilence{20};  // after which a connection is closed

struct HttpRequest {
  std::string method;                            // "GET"
  std::string path;                              // decoded, without the query
  std::map<std::string, std::string> query{};    // likewise; of a name given twice the last
  std::map<std::string, std::string> headers{};  // names in lower case
  std::string body{};
};

struct HttpResponse {
  unsigned status = 200;
  std::string type = "application/json";
  std::string body{};
  std::map<std::string, std::string> headers{};
};

using HttpAnswer = std::function<HttpResponse(const HttpRequest&)>;

class HttpServer {
 public:
  // Listens on 127.0.0.1; port 0: any that is free. Errors: the port is taken, or the system refuses.
  static Result<HttpServer> start(std::uint16_t port, HttpAnswer answer);

  HttpServer(HttpServer&&) noexcept;
  HttpServer& operator=(HttpServer&&) noexcept;
  ~HttpServer();  // waits for answers that are being computed

  std::uint16_t port() const;

 private:
  struct State;
  explicit HttpServer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace coppice
