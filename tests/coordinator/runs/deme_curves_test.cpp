// What is kept of each deme's generations for the page.
#include "coordinator/runs/deme_curves.hpp"

#include <gtest/gtest.h>

namespace coppice {
namespace {

GenerationRecord record(std::uint32_t generation, double fitness) {
  GenerationRecord record{.generation = generation, .best = {Tree(ActionId{0}), generation, fitness, 0.0}};
  record.mean_fitness = fitness / 2;
  record.mean_nodes = 3.0;
  return record;
}

std::vector<std::vector<GenerationRecord>> epoch(std::uint32_t first, std::uint32_t count) {
  std::vector<std::vector<GenerationRecord>> of_demes(2);
  for (std::uint32_t i = first; i < first + count; ++i) {
    of_demes[0].push_back(record(i, i));
    of_demes[1].push_back(record(i, 10.0 * i));
  }
  return of_demes;
}

TEST(DemeCurves, HoldEachDemesGenerationsInOrder) {
  DemeCurves curves;
  EXPECT_TRUE(curves.empty());
  curves.add(epoch(0, 2));
  curves.add(epoch(2, 1));
  const auto json = curves.json();
  EXPECT_EQ(json["generation"], (std::vector<int>{0, 1, 2}));
  ASSERT_EQ(json["demes"].size(), 2U);
  EXPECT_EQ(json["demes"][0]["best_fitness"], (std::vector<double>{0, 1, 2}));
  EXPECT_EQ(json["demes"][1]["best_fitness"], (std::vector<double>{0, 10, 20}));
  EXPECT_EQ(json["demes"][1]["mean_fitness"], (std::vector<double>{0, 5, 10}));
  EXPECT_EQ(json["demes"][0]["best_nodes"], (std::vector<double>{1, 1, 1}));
}

TEST(DemeCurves, AGenerationThatComesAgainTakesThePlaceOfWhatWasThere) {
  DemeCurves curves;
  curves.add(epoch(0, 5));
  curves.add(epoch(3, 1));
  EXPECT_EQ(curves.json()["generation"], (std::vector<int>{0, 1, 2, 3}));
}

TEST(DemeCurves, OfManyGenerationsASampleStaysWithTheLast) {
  DemeCurves curves;
  curves.add(epoch(7, 1000));
  const auto json = curves.json();
  EXPECT_LE(json["generation"].size(), DemeCurves::kMostPoints + 1);
  EXPECT_EQ(json["generation"].front(), 7);
  EXPECT_EQ(json["generation"].back(), 1006);
  EXPECT_EQ(json["demes"][1]["best_fitness"].size(), json["generation"].size());
}

}  // namespace
}  // namespace coppice
