#include "worker/chain_cache.hpp"

#include <fstream>
#include <gtest/gtest.h>
#include <set>
#include <string>

#include "tests/oracles/chains.hpp"
#include "tests/temporary_folder.hpp"

namespace coppice {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kCacheBlock = 1000;

class Cache : public ::testing::Test {
 protected:
  Assembly start() const { return Assembly::start(hash_, bytes_.size(), kCacheBlock).value(); }
  std::size_t blocks() const { return (bytes_.size() + kCacheBlock - 1) / kCacheBlock; }
  void add(Assembly& assembly, std::size_t index) const {
    const std::size_t begin = index * kCacheBlock;
    const auto block = std::span(bytes_).subspan(begin, std::min(kCacheBlock, bytes_.size() - begin));
    ASSERT_TRUE(assembly.add(static_cast<std::uint32_t>(index), block));
  }
  ChainCache cache() const { return std::move(ChainCache::open(folder_.path() / "cache")).value(); }
  fs::path file() const { return folder_.path() / "cache" / (hash_.hex() + ".chain"); }
  // The chain's file holds its first blocks, as of a worker that was killed then.
  void hold(std::size_t count) const {
    ChainCache first = cache();
    Assembly assembly = start();
    EXPECT_EQ(first.resume(assembly), 0U);
    for (std::size_t i = 0; i < count; ++i) {
      add(assembly, i);
    }
    first.keep(assembly);
  }

  testing::TemporaryFolder folder_;
  std::vector<std::uint8_t> bytes_ = to_bytes(oracles::random_chain({.states = 300, .seed = 3}));
  ChainHash hash_ = hash_of(bytes_);
};

TEST_F(Cache, GoesOnBehindTheLastWholeBlock) {
  ASSERT_GT(blocks(), 5U);
  hold(3);
  std::ofstream(file(), std::ios::app) << "cut short";
  ChainCache second = cache();
  Assembly assembly = start();
  EXPECT_EQ(second.resume(assembly), 3U);
  EXPECT_EQ(assembly.missing(2)->first, 3U);
  for (std::size_t i = blocks(); i-- > 3;) {  // backwards: only what none before it is missing of is written
    add(assembly, i);
    second.keep(assembly);
  }
  EXPECT_EQ(fs::file_size(file()), bytes_.size());
  ASSERT_TRUE(std::move(assembly).finish());
  second.done();
  Assembly again = start();
  EXPECT_EQ(second.resume(again), blocks());
  EXPECT_TRUE(std::move(again).finish());
}

TEST_F(Cache, RemovesAFileWhoseBytesDoNotHaveTheHash) {
  hold(blocks());
  {
    std::fstream damage(file(), std::ios::in | std::ios::out | std::ios::binary);
    damage.seekp(1500);
    damage.put(static_cast<char>(~bytes_[1500]));
  }
  ChainCache second = cache();
  Assembly assembly = start();
  EXPECT_EQ(second.resume(assembly), blocks());
  ASSERT_TRUE(assembly.complete());
  EXPECT_FALSE(std::move(assembly).finish());
  second.discard();
  EXPECT_FALSE(fs::exists(file()));
  Assembly again = start();
  EXPECT_EQ(second.resume(again), 0U);
}

TEST_F(Cache, TakesNoMoreThanTheChainsBytesFromAFile) {
  hold(blocks());
  std::ofstream(file(), std::ios::app) << std::string(5000, 'x');
  ChainCache second = cache();
  Assembly assembly = start();
  EXPECT_EQ(second.resume(assembly), blocks());
  EXPECT_TRUE(std::move(assembly).finish());
  EXPECT_EQ(fs::file_size(file()), bytes_.size());
}

TEST_F(Cache, IsWrittenByOneAndReadByOthers) {
  ChainCache writer = cache();
  Assembly writing = start();
  writer.resume(writing);
  add(writing, 0);
  add(writing, 1);
  writer.keep(writing);
  ChainCache reader = cache();
  Assembly reading = start();
  EXPECT_EQ(reader.resume(reading), 2U);
  add(reading, 2);
  reader.keep(reading);
  reader.discard();  // not its own
  EXPECT_EQ(fs::file_size(file()), 2 * kCacheBlock);
  add(writing, 2);
  writer.keep(writing);
  EXPECT_EQ(fs::file_size(file()), 3 * kCacheBlock);
}

TEST_F(Cache, KeepsTheLastUsedFiles) {
  ChainCache used = cache();
  for (std::uint8_t i = 0; i < ChainCache::kMaxFiles + 2; ++i) {
    ChainHash hash{};
    hash.bytes[0] = i;
    Assembly assembly = Assembly::start(hash, kCacheBlock, kCacheBlock).value();
    used.resume(assembly);  // none of them ever comes
    fs::last_write_time(folder_.path() / "cache" / (hash.hex() + ".chain"),
                        fs::file_time_type::clock::now() - std::chrono::hours(24 - i));
  }
  std::set<std::string> firsts;
  for (const auto& entry : fs::directory_iterator(folder_.path() / "cache")) {
    firsts.insert(entry.path().filename().string().substr(0, 2));
  }
  EXPECT_EQ(firsts, (std::set<std::string>{"02", "03", "04", "05"}));
}

TEST_F(Cache, NeedsAFolderThatCanBeWritten) {
  std::ofstream(folder_ / "file") << "no folder";
  const auto opened = ChainCache::open(folder_ / "file");
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().kind, ErrorKind::bad_input);
  EXPECT_NE(opened.error().message.find("--cache: " + (folder_ / "file")), std::string::npos) << opened.error().message;
}

TEST_F(Cache, WithoutADiskCostsNothingButTheCache) {
  ChainCache used = cache();
  fs::remove_all(folder_.path() / "cache");
  Assembly assembly = start();
  EXPECT_EQ(used.resume(assembly), 0U);
  for (std::size_t i = 0; i < blocks(); ++i) {
    add(assembly, i);
    used.keep(assembly);
  }
  EXPECT_TRUE(std::move(assembly).finish());
  used.done();
}

}  // namespace
}  // namespace coppice
