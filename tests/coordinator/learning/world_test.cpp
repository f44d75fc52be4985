#include "coordinator/learning/world.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>

#include "coordinator/learning/room_map.hpp"
#include "tests/coordinator/learning/rooms.hpp"

namespace coppice {
namespace {

class WorldFile : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    path_ = std::filesystem::path(::testing::TempDir()) / (std::string("coppice_") + test->name() + ".room");
  }
  void TearDown() override { std::filesystem::remove(path_); }
  void write(const std::string& text) { std::ofstream(path_, std::ios::binary) << text; }
  std::filesystem::path path_;
};

TEST(World, TheDefaultRoomIsBuiltInAndLikeTheThesis) {
  const auto world = load_world("uav");
  ASSERT_TRUE(world.has_value()) << world.error().message;
  EXPECT_EQ(world->kind, WorldKind::uav);
  const auto map = parse_room(world->room);
  ASSERT_TRUE(map.has_value()) << map.error().message;
  EXPECT_EQ(std::count(map->cells.begin(), map->cells.end(), Cell::trash), 14);
}

TEST(World, KnowsTheWindyGrid) {
  const auto world = load_world("windy");
  ASSERT_TRUE(world.has_value());
  EXPECT_EQ(world->kind, WorldKind::windy);
  EXPECT_TRUE(world->room.empty());
  EXPECT_EQ(vocabulary_of(*world).actions.size(), 4U);
}

TEST(World, KnowsTheRoomWithACharger) {
  const auto world = load_world("battery");
  ASSERT_TRUE(world.has_value()) << world.error().message;
  EXPECT_EQ(world->kind, WorldKind::battery);
  const auto map = parse_room(world->room);
  ASSERT_TRUE(map.has_value()) << map.error().message;
  EXPECT_TRUE(map->charger.has_value());
  EXPECT_EQ(map->starts.size(), 3U);
  EXPECT_EQ(vocabulary_of(*world).actions.back(), "charge");
}

TEST_F(WorldFile, WithAChargerHasABatteryAndGoesThroughAStudy) {
  write("#####\n#^*C#\n#####\n");
  const auto world = load_world(path_.string());
  ASSERT_TRUE(world.has_value()) << world.error().message;
  EXPECT_EQ(world->kind, WorldKind::battery);
  EXPECT_EQ(make_world(std::string(name_of(world->kind)), world->room).value(), *world);
  EXPECT_FALSE(make_world("uav", world->room).has_value());
  EXPECT_FALSE(make_world("battery", "###\n#^#\n###\n").has_value());
}

TEST_F(WorldFile, IsReadAndGoesThroughAStudy) {
  write(testing::joined(testing::small_room()));
  const auto world = load_world(path_.string());
  ASSERT_TRUE(world.has_value()) << world.error().message;
  EXPECT_EQ(world->room, testing::joined(testing::small_room()));
  const auto again = make_world(std::string(name_of(world->kind)), world->room);
  ASSERT_TRUE(again.has_value());
  EXPECT_EQ(*again, *world);
}

TEST_F(WorldFile, ErrorsNameFileLineAndColumn) {
  write("#####\n#.^x#\n#####\n");
  const auto world = load_world(path_.string());
  ASSERT_FALSE(world.has_value());
  EXPECT_EQ(world.error().kind, ErrorKind::bad_input);
  EXPECT_EQ(world.error().message.find(path_.string() + ": line 2, column 4: "), 0U) << world.error().message;
}

TEST_F(WorldFile, IsRefusedWhenFarTooLarge) {
  write(std::string(1U << 20U, '#'));
  const auto world = load_world(path_.string());
  ASSERT_FALSE(world.has_value());
  EXPECT_NE(world.error().message.find(path_.string()), std::string::npos) << world.error().message;
}

TEST(World, AMissingFileAndAFolderAreBadInput) {
  for (const std::string& path : {std::string("no/such/file.room"), ::testing::TempDir()}) {
    const auto world = load_world(path);
    ASSERT_FALSE(world.has_value());
    EXPECT_EQ(world.error().kind, ErrorKind::bad_input);
    EXPECT_NE(world.error().message.find(path), std::string::npos) << world.error().message;
  }
}

TEST(World, AStudysWorldIsChecked) {
  EXPECT_FALSE(make_world("sea", "").has_value());
  EXPECT_FALSE(make_world("uav", "").has_value());
  EXPECT_FALSE(make_world("windy", "###").has_value());
  EXPECT_TRUE(make_world("windy", "").has_value());
}

}  // namespace
}  // namespace coppice
