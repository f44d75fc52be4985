#include "common/wire/configuration.hpp"

#include <gtest/gtest.h>

namespace coppice::wire {
namespace {

TEST(Configuration, NamesTheCoordinatorsPort) {
  EXPECT_EQ(coordinator_port(0), 7410U);
  EXPECT_LT(coordinator_port(kMaxDomain), 65536U);
  const auto worker = worker_configuration("127.0.0.1", 3);
  ASSERT_TRUE(worker.has_value()) << worker.error().message;
  EXPECT_NE(worker->find("127.0.0.1:8160"), std::string::npos) << *worker;
}

TEST(Configuration, TellsInterfacesByNameAndByAddress) {
  EXPECT_NE(coordinator_configuration("lo").find("name=\"lo\""), std::string::npos);
  EXPECT_NE(coordinator_configuration("127.0.0.1").find("address=\"127.0.0.1\""), std::string::npos);
  EXPECT_TRUE(check_interface("lo").has_value());
  EXPECT_TRUE(check_interface("127.0.0.1").has_value());
  const auto unknown = check_interface("no_such_interface0");
  ASSERT_FALSE(unknown.has_value());
  EXPECT_NE(unknown.error().message.find("lo (127.0.0.1)"), std::string::npos) << unknown.error().message;
}

TEST(Configuration, SaysNothingOfWhatIsNotAskedFor) {
  const std::string plain = coordinator_configuration("lo");
  for (const char* element : {"<Security>", "MaxMessageSize", "NackDelay"}) {
    EXPECT_EQ(plain.find(element), std::string::npos) << element;
  }
  const std::string asked = coordinator_configuration("lo", {.security = "/a & \"b\"", .lossy = true, .port = {}});
  EXPECT_NE(asked.find("file:/a &amp; &quot;b&quot;/key.pem"), std::string::npos) << asked;
  EXPECT_NE(asked.find("<MaxMessageSize>1152B</MaxMessageSize>"), std::string::npos) << asked;
  EXPECT_NE(asked.find("<NackDelay>1ms</NackDelay>"), std::string::npos) << asked;
}

TEST(Configuration, RefusesAHostThatDoesNotResolve) {
  const auto worker = worker_configuration("no such host", 0);
  ASSERT_FALSE(worker.has_value());
  EXPECT_EQ(worker.error().kind, ErrorKind::bad_input);
  EXPECT_NE(worker.error().message.find("no such host"), std::string::npos);
}

}  // namespace
}  // namespace coppice::wire
