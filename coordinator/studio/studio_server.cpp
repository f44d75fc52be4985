#include "coordinator/studio/studio_server.hpp"

#include <fmt/format.h>

#include "coordinator/console/json_line.hpp"
#include "coordinator/studio/page_file.hpp"

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kApi = "/api/";

HttpResponse error_response(unsigned status, const std::string& message) {
  return {.status = status, .body = json_line(Json{{"error", message}})};
}

HttpResponse api(StudioSession& session, const HttpRequest& request) {
  if (request.method != "POST") {
    return error_response(405, "expected POST");
  }
  const auto type = request.headers.find("content-type");
  if (type == request.headers.end() || type->second.rfind("application/json", 0) != 0) {
    return error_response(415, "expected application/json");
  }
  // Without exceptions, and with a depth that no request of the page needs: a parser that recurses could be overrun.
  constexpr int kDepth = 16;
  const auto callback = [](int depth, Json::parse_event_t /*event*/, Json& /*parsed*/) { return depth <= kDepth; };
  const Json asked = request.body.empty() ? Json::object() : Json::parse(request.body, callback, false);
  if (asked.is_discarded() || !asked.is_object()) {
    return error_response(400, "the body is no JSON object");
  }
  const std::optional<Result<Json>> answer = session.answer(request.path.substr(kApi.size()), asked);
  if (!answer) {
    return error_response(404, "there is no such thing here");
  }
  if (!*answer) {
    return error_response(answer->error().kind == ErrorKind::bad_input ? 400 : 500, answer->error().message);
  }
  return {.body = json_line(**answer)};
}

HttpResponse routed(const StudioGate& gate, StudioSession& session, const HttpRequest& request) {
  if (std::optional<HttpResponse> refused = refusal(gate, request)) {
    return *refused;
  }
  if (request.path == "/") {
    return request.method == "GET" ? HttpResponse{.type = "text/html; charset=utf-8", .body = studio_page()}
                                   : error_response(405, "expected GET");
  }
  if (request.path.rfind(kApi, 0) == 0) {
    return api(session, request);
  }
  return error_response(404, "there is no such thing here");
}

}  // namespace

HttpResponse answer_of(const StudioGate& gate, StudioSession& session, const HttpRequest& request) {
  HttpResponse response = routed(gate, session, request);
  harden(response);
  return response;
}

}  // namespace coppice
