#include "common/duration.hpp"

#include <gtest/gtest.h>

namespace coppice {
namespace {

using namespace std::chrono_literals;

TEST(Duration, ReadsANumberAndItsUnit) {
  EXPECT_EQ(duration_of("2ms").value(), 2ms);
  EXPECT_EQ(duration_of("500us").value(), 500us);
  EXPECT_EQ(duration_of("1.5s").value(), 1500ms);
  EXPECT_EQ(duration_of("7ns").value(), 7ns);
  EXPECT_EQ(duration_of("3600s").value(), 3600s);
}

TEST(Duration, RefusesWhatIsNone) {
  for (const char* text :
       {"", "2", "ms", "2 ms", "2m", "-2ms", "0s", "0.1ns", "3601s", "1e30s", "nans", "infs", "2msx"}) {
    const auto duration = duration_of(text);
    ASSERT_FALSE(duration.has_value()) << text;
    EXPECT_NE(duration.error().message.find("as in 2ms"), std::string::npos) << duration.error().message;
  }
}

TEST(Duration, IsShownInTheLargestUnitThatItFills) {
  EXPECT_EQ(in_words(2ms), "2 ms");
  EXPECT_EQ(in_words(1530ms), "1.53 s");
  EXPECT_EQ(in_words(-250us), "-250 us");
  EXPECT_EQ(in_words(0ns), "0 s");
}

}  // namespace
}  // namespace coppice
