#include "worker/chain_store.hpp"

#include <gtest/gtest.h>

#include "tests/oracles/chains.hpp"

namespace coppice {
namespace {

constexpr std::size_t kBlock = 1000;

struct Parcel {
  std::vector<std::uint8_t> bytes = to_bytes(oracles::random_chain({.states = 300, .seed = 3}));
  ChainHash hash = hash_of(bytes);
  std::uint32_t blocks() const { return static_cast<std::uint32_t>((bytes.size() + kBlock - 1) / kBlock); }
  std::span<const std::uint8_t> block(std::uint32_t index) const {
    const std::size_t begin = index * kBlock;
    return std::span(bytes).subspan(begin, std::min(kBlock, bytes.size() - begin));
  }
};

TEST(Assembly, PutsAChainTogetherFromBlocksInAnyOrderAndTwice) {
  const Parcel parcel;
  auto assembly = Assembly::start(parcel.hash, parcel.bytes.size(), kBlock);
  ASSERT_TRUE(assembly.has_value());
  for (std::uint32_t i = parcel.blocks(); i-- > 0;) {
    EXPECT_FALSE(assembly->complete());
    ASSERT_TRUE(assembly->add(i, parcel.block(i)).has_value());
    ASSERT_TRUE(assembly->add(i, parcel.block(i)).has_value());
  }
  ASSERT_TRUE(assembly->complete());
  const auto chain = std::move(*assembly).finish();
  ASSERT_TRUE(chain.has_value()) << chain.error().message;
  EXPECT_EQ(to_bytes((*chain)->chain()), parcel.bytes);
}

TEST(Assembly, AsksForWhatIsMissingAndNothingElse) {
  const Parcel parcel;
  auto assembly = Assembly::start(parcel.hash, parcel.bytes.size(), kBlock);
  ASSERT_GE(parcel.blocks(), 6U);
  EXPECT_EQ(assembly->missing(4)->first, 0U);
  EXPECT_EQ(assembly->missing(4)->count, 4U);
  ASSERT_TRUE(assembly->add(0, parcel.block(0)).has_value());
  ASSERT_TRUE(assembly->add(3, parcel.block(3)).has_value());
  EXPECT_EQ(assembly->missing(4)->first, 1U);
  EXPECT_EQ(assembly->missing(4)->count, 2U);
}

TEST(Assembly, RefusesBlocksThatDoNotFitAndBytesThatDoNotHaveTheHash) {
  const Parcel parcel;
  auto assembly = Assembly::start(parcel.hash, parcel.bytes.size(), kBlock);
  EXPECT_FALSE(assembly->add(parcel.blocks(), parcel.block(0)).has_value());
  EXPECT_FALSE(assembly->add(0, parcel.block(0).first(10)).has_value());
  for (std::uint32_t i = 0; i < parcel.blocks(); ++i) {
    std::vector<std::uint8_t> block(parcel.block(i).begin(), parcel.block(i).end());
    block[0] ^= i == 1 ? 1U : 0U;
    ASSERT_TRUE(assembly->add(i, block).has_value());
  }
  EXPECT_FALSE(std::move(*assembly).finish().has_value());
  EXPECT_FALSE(Assembly::start(parcel.hash, 0, kBlock).has_value());
  EXPECT_FALSE(Assembly::start(parcel.hash, Assembly::kMaxChainBytes + 1, kBlock).has_value());
}

TEST(ChainStore, KeepsTheLastFewChains) {
  ChainStore store;
  const auto chain = PreparedChain::make(oracles::shared_random_chain({.states = 10}));
  std::vector<ChainHash> hashes;
  for (std::uint8_t i = 0; i <= ChainStore::kMaxChains; ++i) {
    ChainHash hash;
    hash.bytes[0] = i;
    hashes.push_back(hash);
    store.add(hash, chain);
  }
  EXPECT_EQ(store.find(hashes.front()), nullptr);
  EXPECT_EQ(store.find(hashes.back()), chain);
  EXPECT_EQ(store.held().size(), ChainStore::kMaxChains);
}

}  // namespace
}  // namespace coppice
