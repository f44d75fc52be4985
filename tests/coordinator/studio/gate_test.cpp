// Who may talk to the studio.
#include <gtest/gtest.h>
#include <set>

#include "coordinator/studio/studio_gate.hpp"

namespace coppice {
namespace {

const StudioGate kGate{.token = "0123456789abcdef0123456789abcdef", .port = 8123};

HttpRequest page() {
  return {.method = "GET", .path = "/", .query = {{"token", kGate.token}}, .headers = {{"host", "127.0.0.1:8123"}}};
}
HttpRequest question() {
  return {.method = "POST",
          .path = "/api/status",
          .headers = {{"host", "localhost:8123"},
                      {"origin", "http://localhost:8123"},
                      {"sec-fetch-site", "same-origin"},
                      {"x-coppice-token", kGate.token}}};
}
unsigned status_of(const HttpRequest& request) {
  const auto refused = refusal(kGate, request);
  return refused ? refused->status : 200;
}

TEST(StudioGate, LetsItsOwnPageIn) {
  EXPECT_EQ(status_of(page()), 200U);
  EXPECT_EQ(status_of(question()), 200U);
}

TEST(StudioGate, ATokenIsNotGuessed) {
  std::set<std::string> tokens;
  for (int i = 0; i < 100; ++i) {
    const std::string token = new_token();
    EXPECT_EQ(token.size(), 32U);
    EXPECT_EQ(token.find_first_not_of("0123456789abcdef"), std::string::npos);
    tokens.insert(token);
  }
  EXPECT_EQ(tokens.size(), 100U);
}

TEST(StudioGate, RefusesAWrongTokenWhereverItIs) {
  for (const std::string& token : {std::string(), kGate.token.substr(1), kGate.token + "0", std::string(32, '0')}) {
    HttpRequest request = page();
    request.query["token"] = token;
    EXPECT_EQ(status_of(request), 403U) << token;
    HttpRequest asked = question();
    asked.headers["x-coppice-token"] = token;
    EXPECT_EQ(status_of(asked), 403U) << token;
  }
  HttpRequest in_the_query = question();
  in_the_query.headers.erase("x-coppice-token");
  in_the_query.query["token"] = kGate.token;
  EXPECT_EQ(status_of(in_the_query), 403U) << "a link of another site could carry it";
}

TEST(StudioGate, RefusesNamesThatOnlyPointHere) {
  for (const char* host :
       {"evil.example", "evil.example:8123", "127.0.0.1", "127.0.0.1:81231", "127.0.0.1:8123.evil", ""}) {
    HttpRequest request = page();
    request.headers["host"] = host;
    EXPECT_EQ(status_of(request), 421U) << host;
  }
}

TEST(StudioGate, RefusesOtherSites) {
  for (const char* origin : {"http://evil.example", "null", "http://127.0.0.1:8124", "https://localhost:8123", ""}) {
    HttpRequest request = question();
    request.headers["origin"] = origin;
    EXPECT_EQ(status_of(request), 403U) << origin;
  }
  HttpRequest across = question();
  across.headers["sec-fetch-site"] = "cross-site";
  EXPECT_EQ(status_of(across), 403U);
}

TEST(StudioGate, ARefusalSaysNothingOfTheStudyAndEveryAnswerIsHardened) {
  HttpRequest request = page();
  request.query.clear();
  HttpResponse refused = *refusal(kGate, request);
  EXPECT_EQ(refused.body.find(kGate.token), std::string::npos);
  harden(refused);
  EXPECT_EQ(refused.headers.at("Cache-Control"), "no-store");
  EXPECT_EQ(refused.headers.at("X-Frame-Options"), "DENY");
  EXPECT_NE(refused.headers.at("Content-Security-Policy").find("default-src 'none'"), std::string::npos);
}

}  // namespace
}  // namespace coppice
