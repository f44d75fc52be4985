// Who may talk to the studio: this machine's browser, from the studio's own page, with the token that was printed. A
// page of another site that a browser shows at the same time has the machine's address but not the token; a name that
// an attacker lets point to 127.0.0.1 (DNS rebinding) is told by the Host header; another site's script by Origin.
// Pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "coordinator/studio/http_server.hpp"

namespace coppice {

struct StudioGate {
  std::string token;  // 32 hexadecimal digits
  std::uint16_t port = 0;
};

// 128 bits from the system's generator. Throws std::runtime_error where there is none.
std::string new_token();

// "http://127.0.0.1:8123/?token=...".
std::string address_of(const StudioGate& gate);

// The refusal, which says nothing about the study; nothing: the request may pass. Asks for the token in the query for
// the page and in X-Coppice-Token for everything else, which no other site can set without being asked first.
std::optional<HttpResponse> refusal(const StudioGate& gate, const HttpRequest& request);

// What every answer carries: no caching, no framing, no sniffing, no referrer.
void harden(HttpResponse& response);

}  // namespace coppice
