#include "common/metrics/outlet.hpp"

#include <atomic>
#include <fmt/format.h>
#include <gtest/gtest.h>

namespace coppice {
namespace {

TEST(MetricsPlace, IsAPortOrAnAddressWithOne) {
  const auto place = [](const std::string& text) {
    const auto read = metrics_place("--metrics", text);
    return read ? fmt::format("{} {}", read->address, read->port) : read.error().message;
  };
  EXPECT_EQ(place("9470"), "127.0.0.1 9470");
  EXPECT_EQ(place("0.0.0.0:9470"), "0.0.0.0 9470");
  EXPECT_EQ(place("[::1]:80"), "::1 80");
  for (const char* wrong : {"", "host:1", "1:2:3", "65536", "-1", "127.0.0.1:", "127.0.0.1:9470x", "[::1]"}) {
    EXPECT_EQ(place(wrong).rfind(fmt::format("--metrics {}: expected PORT", wrong), 0), 0U) << place(wrong);
  }
}

TEST(MetricsOutlet, AnswersForHealthOnEitherFamilyOfAddresses) {
  std::atomic<bool> alive{true};
  for (const char* place : {"127.0.0.1:0", "[::1]:0"}) {
    alive = true;
    auto outlet =
        MetricsOutlet::open({.place = place, .file = {}}, {.text = [] { return std::string("x 1\n"); },
                                                           .health =
                                                               [&] {
                                                                 return Health{alive, false, alive ? "well" : "hangs"};
                                                               }});
    ASSERT_TRUE(outlet.has_value()) << outlet.error().message;
    const std::string there =
        std::string(place).substr(0, std::string(place).size() - 1) + std::to_string((*outlet)->port());
    EXPECT_EQ(ask_health("--health", there, "/health").value_or("failed"), "well");
    const auto ready = ask_health("--health", there, "/ready");
    ASSERT_FALSE(ready.has_value());
    EXPECT_EQ(ready.error().message, "well");
    EXPECT_EQ(ask_health("--health", there, "/metrics").value_or("failed"), "x 1");
    const auto nowhere = ask_health("--health", there, "/nowhere");
    ASSERT_FALSE(nowhere.has_value());
    EXPECT_EQ(nowhere.error().message, "expected /metrics, /health or /ready");
    alive = false;
    EXPECT_FALSE(ask_health("--health", there, "/health").has_value());
  }
}

TEST(MetricsOutlet, SaysWhatItCannotListenTo) {
  const auto first = MetricsOutlet::open({.place = "0", .file = {}}, {.text = [] { return std::string(); }});
  ASSERT_TRUE(first.has_value());
  const auto second = MetricsOutlet::open({.place = std::to_string((*first)->port()), .file = {}},
                                          {.text = [] { return std::string(); }});
  ASSERT_FALSE(second.has_value());
  EXPECT_EQ(second.error().kind, ErrorKind::bad_input);
  EXPECT_NE(second.error().message.find("Address already in use"), std::string::npos) << second.error().message;
}

}  // namespace
}  // namespace coppice
