#include "coordinator/console/whole_file.hpp"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <string>
#include <vector>

#include "tests/temporary_folder.hpp"

namespace coppice {
namespace {

namespace fs = std::filesystem;

class WholeFile : public ::testing::Test {
 protected:
  std::string content(const char* name) const {
    std::ifstream in(folder_ / name);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  testing::TemporaryFolder temporary_;
  fs::path folder_ = temporary_.path();
};

TEST_F(WholeFile, ReplacesWhatWasThere) {
  ASSERT_TRUE(write_whole_file(folder_ / "a.txt", "one"));
  ASSERT_TRUE(write_whole_file(folder_ / "a.txt", "two"));
  EXPECT_EQ(content("a.txt"), "two");
  EXPECT_EQ(files(), 1U);
}

TEST_F(WholeFile, AFailureHalfwayLeavesTheOldContentAndNothingElse) {
  ASSERT_TRUE(write_whole_file(folder_ / "a.txt", "old"));
  const auto written = produce_whole_file(folder_ / "a.txt", [](const fs::path& temporary) -> Result<void> {
    std::ofstream(temporary) << "half";
    return failed("the ink ran out");
  });
  ASSERT_FALSE(written);
  EXPECT_NE(written.error().message.find("a.txt: the ink ran out"), std::string::npos) << written.error().message;
  EXPECT_EQ(content("a.txt"), "old");
  EXPECT_EQ(files(), 1U);
}

TEST_F(WholeFile, ALinkStaysAndItsTargetKeepsItsMode) {
  ASSERT_TRUE(write_whole_file(folder_ / "a.txt", "one"));
  fs::permissions(folder_ / "a.txt", fs::perms::owner_read | fs::perms::owner_write);
  fs::create_symlink("a.txt", folder_ / "link.txt");
  ASSERT_TRUE(write_whole_file(folder_ / "link.txt", "two"));
  EXPECT_TRUE(fs::is_symlink(folder_ / "link.txt"));
  EXPECT_EQ(content("a.txt"), "two");
  EXPECT_EQ(fs::status(folder_ / "a.txt").permissions(), fs::perms::owner_read | fs::perms::owner_write);
  fs::create_symlink("later.txt", folder_ / "dangling.txt");
  ASSERT_TRUE(write_whole_file(folder_ / "dangling.txt", "three"));
  EXPECT_EQ(content("later.txt"), "three");
}

TEST_F(WholeFile, WhatIsNoRegularFileIsNotReplaced) {
  fs::create_symlink("/dev/full", folder_ / "full");
  const auto written = write_whole_file(folder_ / "full", "text");
  ASSERT_FALSE(written);
  EXPECT_TRUE(fs::is_character_file(folder_ / "full"));
  EXPECT_FALSE(write_whole_file(folder_, "text"));
  EXPECT_EQ(files(), 1U);
}

TEST_F(WholeFile, TheInputIsRecognisedByAnyName) {
  ASSERT_TRUE(write_whole_file(folder_ / "a.txt", "one"));
  fs::create_hard_link(folder_ / "a.txt", folder_ / "b.txt");
  const auto same = check_other_file("-o", folder_ / "b.txt", folder_ / "a.txt");
  ASSERT_FALSE(same);
  EXPECT_EQ(same.error().kind, ErrorKind::bad_input);
  EXPECT_TRUE(check_other_file("-o", folder_ / "new.txt", folder_ / "a.txt"));
}

TEST_F(WholeFile, AFolderThatIsMissingIsNamed) {
  const auto written = write_whole_file(folder_ / "nowhere" / "a.txt", "text");
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().kind, ErrorKind::failed);
  EXPECT_NE(written.error().message.find("nowhere/a.txt"), std::string::npos) << written.error().message;
  EXPECT_EQ(files(), 0U);
}

TEST_F(WholeFile, AProducerThatWritesNothingIsAFailure) {
  EXPECT_FALSE(produce_whole_file(folder_ / "a.txt", [](const fs::path&) -> Result<void> { return {}; }));
  EXPECT_EQ(files(), 0U);
}

}  // namespace
}  // namespace coppice
