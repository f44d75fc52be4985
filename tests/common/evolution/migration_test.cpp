#include "common/evolution/migration.hpp"

#include <gtest/gtest.h>
#include <set>

namespace coppice {
namespace {

TEST(Migration, DealsOutEverySlotOnceAsEvenlyAsItGoes) {
  for (const std::uint32_t population : {20U, 101U, 800U}) {
    for (const std::uint32_t demes : {1U, 3U, 7U, 10U}) {
      GaConfig ga;
      ga.population = population;
      ga.demes = demes;
      std::uint32_t next = 0;
      for (std::uint32_t deme = 0; deme < demes; ++deme) {
        const DemeShare share = share_of(ga, deme);
        EXPECT_EQ(share.first, next);
        EXPECT_LE(population / demes, share.size);
        EXPECT_LE(share.size, population / demes + 1);
        next += share.size;
      }
      EXPECT_EQ(next, population);
    }
  }
}

TEST(Migration, EpochsAreAllGenerationsAndOneDemeHasOne) {
  GaConfig ga;
  ga.generations = 50;
  ga.epoch = 20;
  EXPECT_EQ(epochs_of(ga), 1U);
  EXPECT_EQ(epoch_end(ga, 0), 50U);
  ga.demes = 2;
  EXPECT_EQ(epochs_of(ga), 3U);
  EXPECT_EQ(epoch_end(ga, 1), 40U);
  EXPECT_EQ(epoch_end(ga, 2), 50U);
  ga.epoch = 25;
  EXPECT_EQ(epochs_of(ga), 2U);
  ga.epoch = 0;
  EXPECT_EQ(epochs_of(ga), 1U);
}

TEST(Migration, EveryDemeSendsToOneOtherAndIsSentByOne) {
  EvolveConfig config;
  for (const Migration migration : {Migration::ring, Migration::random}) {
    config.ga.migration = migration;
    for (const std::uint32_t demes : {2U, 3U, 8U}) {
      config.ga.demes = demes;
      EXPECT_TRUE(senders_of(config, 0).empty()) << "nobody has lived yet";
      for (std::uint32_t epoch = 1; epoch < 20; ++epoch) {
        const auto senders = senders_of(config, epoch);
        EXPECT_EQ(std::set<std::uint32_t>(senders.begin(), senders.end()).size(), demes);
        for (std::uint32_t deme = 0; deme < demes; ++deme) {
          EXPECT_NE(senders[deme], deme);
        }
      }
    }
  }
  config.ga.demes = 8;
  std::set<std::vector<std::uint32_t>> seen;
  for (std::uint32_t epoch = 1; epoch < 20; ++epoch) {
    seen.insert(senders_of(config, epoch));
  }
  EXPECT_GT(seen.size(), 10U) << "drawn anew for each epoch";
  config.ga.migrants = 0;
  EXPECT_TRUE(senders_of(config, 3).empty());
}

}  // namespace
}  // namespace coppice
