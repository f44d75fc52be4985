#include "coordinator/studio/studio_gate.hpp"

#include <array>
#include <cerrno>
#include <fmt/format.h>
#include <stdexcept>
#include <string_view>
#include <sys/random.h>

namespace coppice {
namespace {

std::string value_of(const std::map<std::string, std::string>& values, const char* name) {
  const auto found = values.find(name);
  return found == values.end() ? "" : found->second;
}

// In a time that does not depend on where they differ.
bool same_secret(std::string_view given, std::string_view secret) {
  unsigned difference = given.size() == secret.size() ? 0U : 1U;
  for (std::size_t i = 0; i < secret.size(); ++i) {
    const char c = i < given.size() ? given[i] : '\0';
    difference |= static_cast<unsigned>(static_cast<unsigned char>(c) ^ static_cast<unsigned char>(secret[i]));
  }
  return difference == 0U;
}

HttpResponse refused(unsigned status, const char* why) {
  return {.status = status, .body = fmt::format(R"({{"error":"{}"}})", why)};
}

}  // namespace

std::string new_token() {
  std::array<unsigned char, 16> bytes{};
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    throw std::runtime_error("the system gives no random bytes for a token");
  }
  std::string token;
  for (const unsigned char byte : bytes) {
    token += fmt::format("{:02x}", byte);
  }
  return token;
}

std::string address_of(const StudioGate& gate) {
  return fmt::format("http://127.0.0.1:{}/?token={}", gate.port, gate.token);
}

std::optional<HttpResponse> refusal(const StudioGate& gate, const HttpRequest& request) {
  const std::string host = value_of(request.headers, "host");
  const std::string numbers = fmt::format("127.0.0.1:{}", gate.port);
  const std::string name = fmt::format("localhost:{}", gate.port);
  if (host != numbers && host != name) {
    return refused(421, "this is not the host that the studio serves");
  }
  if (const auto origin = request.headers.find("origin");
      origin != request.headers.end() && origin->second != "http://" + host) {
    return refused(403, "the studio answers its own page only");
  }
  if (const std::string site = value_of(request.headers, "sec-fetch-site");
      !site.empty() && site != "same-origin" && site != "none") {
    return refused(403, "the studio answers its own page only");
  }
  const bool is_page = request.path == "/";
  const std::string given = is_page ? value_of(request.query, "token") : value_of(request.headers, "x-coppice-token");
  if (!same_secret(given, gate.token)) {
    return refused(403, "the token is missing or wrong: use the address that 'coppice studio' printed");
  }
  return std::nullopt;
}

void harden(HttpResponse& response) {
  response.headers.insert({{"Cache-Control", "no-store"},
                           {"X-Content-Type-Options", "nosniff"},
                           {"X-Frame-Options", "DENY"},
                           {"Referrer-Policy", "no-referrer"},
                           {"Cross-Origin-Resource-Policy", "same-origin"},
                           {"Cross-Origin-Opener-Policy", "same-origin"}});
  // The page brings a policy of its own with the hashes of its script and style; both hold. An answer is no page.
  response.headers.insert({"Content-Security-Policy", response.type == "text/html; charset=utf-8"
                                                          ? "frame-ancestors 'none'"
                                                          : "default-src 'none'; frame-ancestors 'none'"});
}

}  // namespace coppice
