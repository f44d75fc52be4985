#include "common/wire/codec.hpp"

#include <gtest/gtest.h>

#include "tests/oracles/chains.hpp"
#include "tests/oracles/trees.hpp"

namespace coppice::wire {
namespace {

const Vocabulary& vocabulary() {
  static const Vocabulary words = oracles::random_chain({.states = 10}).vocabulary();
  return words;
}

Result<DecodedTask> decode(std::span<const std::uint8_t> payload) { return TaskDecoder(vocabulary()).decode(payload); }

Job job_with_rules() {
  Job job;
  job.seed = 0x0123456789ABCDEF;
  job.generation = 17;
  job.rollouts = 3;
  job.steps = 9;
  job.acting = Acting::mixed;
  job.policy_share = ~std::uint64_t{0};
  job.method = Method::discounted;
  job.gamma = 0xF0F1F2F3F4F5F6F7;
  job.objectives = {{ObjectiveKind::coverage, {}},
                    {ObjectiveKind::shaped,
                     {{{Node::condition(0, Op::equal, 3), Node::condition(5, Op::less_equal, 1)}, 8, -4}, {{}, 1, 0}}}};
  return job;
}

TEST(TaskCodec, RoundTrip) {
  const auto trees = oracles::random_trees(vocabulary(), 300, 4);
  const auto payload = encode_task(job_with_rules(), trees);
  const auto task = decode(payload);
  ASSERT_TRUE(task.has_value()) << task.error().message;
  EXPECT_EQ(task->job, job_with_rules());
  EXPECT_EQ(task->trees, trees);
  std::size_t most = encode_task(job_with_rules(), {}).size();
  for (const Tree& tree : trees) {
    most += most_encoded_bytes(tree.size());
  }
  EXPECT_LE(payload.size(), most);
}

TEST(TaskCodec, UsesATasksMemoryAgainWithoutATrace) {
  const auto large = oracles::random_trees(vocabulary(), 40, 4);
  const auto small = oracles::random_trees(vocabulary(), 25, 5);
  TaskDecoder decoder(vocabulary());
  for (int i = 0; i < 3; ++i) {
    for (const auto& trees : {large, small}) {
      const auto payload = encode_task(Job{}, trees);
      EXPECT_FALSE(decoder.decode(std::span(payload).first(payload.size() - 1)).has_value());
      auto task = decoder.decode(payload);
      ASSERT_TRUE(task.has_value()) << task.error().message;
      EXPECT_EQ(task->trees, trees);
      decoder.recycle(std::move(*task));
    }
  }
}

TEST(TaskCodec, CarriesEveryMethodAndRefusesAnyOther) {
  constexpr std::size_t kMethodAt = 29;
  for (std::uint8_t method = 0; method < kMethods; ++method) {
    Job job;
    job.method = Method{method};
    auto payload = encode_task(job, {});
    EXPECT_EQ(payload[kMethodAt], method);
    const auto task = decode(payload);
    ASSERT_TRUE(task.has_value()) << task.error().message;
    EXPECT_EQ(task->job, job);
    payload[kMethodAt] = kMethods;
    const auto refused = decode(payload);
    ASSERT_FALSE(refused.has_value());
    EXPECT_EQ(refused.error().message, "method 4 is unknown");
  }
}

TEST(TaskCodec, RefusesEveryTruncationAndEverySurplus) {
  auto payload = encode_task(job_with_rules(), oracles::random_trees(vocabulary(), 5, 4));
  for (std::size_t length = 0; length < payload.size(); ++length) {
    EXPECT_FALSE(decode(std::span(payload).first(length)).has_value()) << length;
  }
  payload.push_back(0);
  EXPECT_FALSE(decode(payload).has_value());
}

TEST(TaskCodec, WhateverItReturnsIsWellFormed) {
  auto payload = encode_task(job_with_rules(), oracles::random_trees(vocabulary(), 5, 4));
  Xoshiro256 random(12);
  int accepted = 0;
  for (int i = 0; i < 50'000; ++i) {
    auto damaged = payload;
    for (std::uint64_t flips = 1 + random.below(3); flips > 0; --flips) {
      damaged[random.below(damaged.size())] = static_cast<std::uint8_t>(random.next());
    }
    if (const auto task = decode(damaged)) {
      ++accepted;
      EXPECT_TRUE(check_job(task->job).has_value());
      for (const Tree& tree : task->trees) {
        EXPECT_TRUE(check_tree(tree, vocabulary()).has_value());
      }
      EXPECT_EQ(encode_task(task->job, task->trees), damaged);
    }
  }
  EXPECT_GT(accepted, 1000);  // a changed seed or action is still a task
}

TEST(TaskCodec, RefusesTreesOfAnotherVocabulary) {
  Vocabulary smaller = vocabulary();
  smaller.actions.resize(1);
  const auto payload = encode_task(Job{}, std::vector<Tree>{Tree(ActionId{2})});
  const auto task = TaskDecoder(smaller).decode(payload);
  ASSERT_FALSE(task.has_value());
  EXPECT_NE(task.error().message.find("action 2"), std::string::npos) << task.error().message;
}

TEST(TallyCodec, RoundTripAndNothingElse) {
  std::vector<Tally> tallies;
  for (std::uint32_t i = 0; i < 50; ++i) {
    tallies.push_back({i, i * 7ULL, 500, {-1 - std::int64_t{i}, std::int64_t{1} << 60U}});
  }
  auto payload = encode_tallies(tallies);
  const auto back = decode_tallies(payload, 50, 2);
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(*back, tallies);
  EXPECT_FALSE(decode_tallies(payload, 49, 2).has_value());
  EXPECT_FALSE(decode_tallies(payload, 50, 1).has_value());
  payload.pop_back();
  EXPECT_FALSE(decode_tallies(payload, 50, 2).has_value());
  EXPECT_FALSE(decode_tallies({}, 0, 2).has_value());
}

}  // namespace
}  // namespace coppice::wire
