// A chain prepared, and one tree evaluated, in a line each.
#pragma once

#include <gtest/gtest.h>
#include <memory>
#include <utility>

#include "common/fitness/evaluation.hpp"

namespace coppice {

inline std::shared_ptr<const PreparedChain> prepare(Chain chain) {
  return PreparedChain::make(std::make_shared<const Chain>(std::move(chain)));
}

inline Tally evaluate(const std::shared_ptr<const PreparedChain>& chain, const Job& job, const Tree& tree) {
  auto prepared = PreparedJob::make(chain, job);
  EXPECT_TRUE(prepared.has_value()) << (prepared ? "" : prepared.error().message);
  return Evaluation(*prepared).evaluate(tree);
}

}  // namespace coppice
