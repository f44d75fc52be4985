#include "common/wire/epoch_codec.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <memory>

#include "common/chain/random.hpp"
#include "common/evolution/migration.hpp"
#include "tests/oracles/chains.hpp"

namespace coppice::wire {
namespace {

EvolveConfig deme_config(Search search) {
  EvolveConfig config;
  config.seed = ~std::uint64_t{0};
  config.ga.search = search;
  config.ga.generations = 6;
  config.ga.population = 21;
  config.ga.demes = 2;
  config.ga.epoch = 2;
  config.ga.migrants = 3;
  config.ga.migration = Migration::random;
  config.ga.max_nodes = 25;
  config.rollout.rollouts = 2;
  config.rollout.steps = 20;
  config.fitness.coverage = 0.1 + 0.2;
  config.fitness.shaped = 0.5;
  config.fitness.rules = {{{"f3=3", "f4=3"}, 8, -4}, {{}, 1, 0}};
  config.front.members = 9;
  config.front.objectives = {measure_of(ObjectiveKind::agreement), measure_of(ObjectiveKind::coverage), kNodesMeasure};
  return config;
}

class EpochCodec : public ::testing::TestWithParam<Search> {
 protected:
  EpochCodec() {
    EpochRunner runner(PreparedChain::make(chain_));
    const auto go_on = [](std::size_t) { return true; };
    first_ = {.number = 1, .until = 2, .deme = nullptr, .migrants = {}};
    first_result_ = runner.run(*config_, first_, go_on).value();
    second_ = {.number = 1,
               .until = 4,
               .deme = std::make_shared<const Deme>(first_result_.deme),
               .migrants = first_result_.emigrants};
    second_result_ = runner.run(*config_, second_, go_on).value();
  }

  std::vector<std::uint8_t> packed(const EpochTask& task) const {
    return encode_epoch_task(encode_configuration(*config_, task.deme == nullptr), task);
  }

  const std::shared_ptr<const Chain> chain_ = std::make_shared<const Chain>(oracles::random_chain({.states = 60}));
  const std::shared_ptr<const EvolveConfig> config_ = std::make_shared<const EvolveConfig>(deme_config(GetParam()));
  EpochTask first_;
  EpochTask second_;
  EpochResult first_result_;
  EpochResult second_result_;
};

TEST_P(EpochCodec, TasksAndResultsComeBackAsTheyWere) {
  EpochDecoder decoder(*chain_);
  for (const EpochTask* const task : {&first_, &second_, &first_}) {
    const auto payload = packed(*task);
    EXPECT_LE(payload.size(), most_epoch_bytes(*config_, EpochCheck(*chain_, *config_).objectives()));
    const auto decoded = decoder.decode_task(payload);
    ASSERT_TRUE(decoded.has_value()) << decoded.error().message;
    EvolveConfig expected = *config_;
    expected.front.pick = EvolveConfig().front.pick;
    EXPECT_EQ(*decoded->config, expected) << "whoever breeds needs no rule that picks an answer";
    EXPECT_EQ(decoded->task.number, task->number);
    EXPECT_EQ(decoded->task.until, task->until);
    EXPECT_EQ(decoded->task.migrants, task->migrants);
    ASSERT_EQ(decoded->task.deme == nullptr, task->deme == nullptr);
    EXPECT_TRUE(task->deme == nullptr || *decoded->task.deme == *task->deme);
  }
  for (const auto& [task, result] : {std::pair{&first_, &first_result_}, std::pair{&second_, &second_result_}}) {
    const auto payload = encode_epoch_result(*result);
    EXPECT_LE(payload.size(), most_epoch_bytes(*config_, EpochCheck(*chain_, *config_).objectives()));
    const auto decoded = decoder.decode_result(payload, config_, *task);
    ASSERT_TRUE(decoded.has_value()) << decoded.error().message;
    EXPECT_EQ(*decoded, *result);
  }
}

TEST_P(EpochCodec, WhatAWorkerComputesIsWhatIsComputedHere) {
  EpochDecoder decoder(*chain_);
  const auto decoded = decoder.decode_task(packed(second_));
  ASSERT_TRUE(decoded.has_value());
  EpochRunner elsewhere(PreparedChain::make(chain_));
  EXPECT_EQ(elsewhere.run(*decoded->config, decoded->task, [](std::size_t) { return true; }).value(), second_result_);
}

TEST_P(EpochCodec, FoundersTravelWithDemesThatBegin) {
  EvolveConfig config = *config_;
  config.ga.founders = "(selector (sequence f3=3 a0) a1); a0";
  EpochDecoder decoder(*chain_);
  const auto begins = decoder.decode_task(encode_epoch_task(encode_configuration(config, true), first_));
  ASSERT_TRUE(begins.has_value()) << begins.error().message;
  EXPECT_EQ(begins->config->ga.founders, config.ga.founders);
  const auto goes_on = decoder.decode_task(encode_epoch_task(encode_configuration(config, false), second_));
  ASSERT_TRUE(goes_on.has_value());
  EXPECT_EQ(goes_on->config->ga.founders, "");
}

TEST_P(EpochCodec, EveryCutAndEveryByteMoreIsRefused) {
  EpochDecoder decoder(*chain_);
  for (const auto& payload : {packed(first_), packed(second_)}) {
    for (std::size_t size = 0; size < payload.size(); ++size) {
      EXPECT_FALSE(decoder.decode_task(std::span(payload).first(size)).has_value()) << size;
    }
    auto longer = payload;
    longer.push_back(0);
    EXPECT_FALSE(decoder.decode_task(longer).has_value());
  }
  const auto payload = encode_epoch_result(second_result_);
  for (std::size_t size = 0; size < payload.size(); ++size) {
    EXPECT_FALSE(decoder.decode_result(std::span(payload).first(size), config_, second_).has_value()) << size;
  }
  auto longer = payload;
  longer.push_back(0);
  EXPECT_FALSE(decoder.decode_result(longer, config_, second_).has_value());
}

TEST_P(EpochCodec, WhateverIsAcceptedIsWrittenInOneWayOnlyAndCanBeRun) {
  EpochDecoder decoder(*chain_);
  EpochRunner runner(PreparedChain::make(chain_));
  Xoshiro256 random(11);
  std::size_t accepted = 0;
  for (int round = 0; round < 4000; ++round) {
    auto payload = packed(round % 2 == 0 ? first_ : second_);
    payload[random.below(payload.size())] = static_cast<std::uint8_t>(random.next());
    const auto decoded = decoder.decode_task(payload);
    if (!decoded) {
      EXPECT_EQ(decoded.error().kind, ErrorKind::bad_input);
      EXPECT_FALSE(decoded.error().message.empty());
      continue;
    }
    ++accepted;
    const auto again = encode_epoch_task(encode_configuration(*decoded->config, payload[4] == 1), decoded->task);
    EXPECT_EQ(again, payload);
    if (round % 20 < 2) {  // a fuzzed number of steps or nodes can take long
      EvolveConfig config = *decoded->config;
      if (std::uint64_t{config.rollout.steps} * config.rollout.rollouts <= 1000 && config.ga.max_nodes <= 100 &&
          config.ga.population <= 300 && config.front.restarts <= 10 &&
          decoded->task.until - (decoded->task.deme ? decoded->task.deme->generations : 0) <= 10) {
        const auto result = runner.run(config, decoded->task, [](std::size_t) { return true; });
        EXPECT_TRUE(result.has_value() || result.error().kind == ErrorKind::bad_input);
      }
    }
  }
  EXPECT_GT(accepted, 500U);
}

TEST_P(EpochCodec, AResultOfAnotherTaskIsRefused) {
  EpochDecoder decoder(*chain_);
  EXPECT_FALSE(decoder.decode_result(encode_epoch_result(first_result_), config_, second_).has_value());
  EpochResult fewer = second_result_;
  fewer.deme.population.pop_back();
  EXPECT_FALSE(decoder.decode_result(encode_epoch_result(fewer), config_, second_).has_value());
  EpochResult more = second_result_;
  more.emigrants.resize(config_->ga.migrants + 1, second_result_.deme.population.front());
  EXPECT_FALSE(decoder.decode_result(encode_epoch_result(more), config_, second_).has_value());
}

INSTANTIATE_TEST_SUITE_P(OfBothSearches, EpochCodec, ::testing::Values(Search::scalar, Search::front),
                         [](const auto& search) { return std::string(name_of(search.param)); });

}  // namespace
}  // namespace coppice::wire
