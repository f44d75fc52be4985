// read_given_policy(): Q-tables as .npy or CSV, for a model of two states. Whatever is accepted has a number or none
// for every pair, and a policy of actions that the states have.
#include "coordinator/exchange/given_policy.hpp"

#include <cmath>

#include "tests/fuzz/memory_file.hpp"
#include "tests/fuzz/target.hpp"

namespace coppice::fuzz {
namespace {

Model two_states() {
  Model model;
  model.feature_names = {"x", "y"};
  model.readings = {0, 1, 1, 0};
  model.action_names = {"a", "b"};
  model.row_begin = {0, 1, 2, 3, 3};  // the second state lacks b
  model.successor = {1, 0, 0};
  model.probability = {1, 1, 1};
  model.reward = {0, 0, 1, 0};
  model.starts = {{0, 1.0}};
  return model;
}

void test(std::string_view bytes) {
  const MemoryFile file(bytes);
  Model model = two_states();
  const auto policy = read_given_policy("", file.path(), model);
  const auto given = read_given_policy(file.path(), "", model);
  accepted = given.has_value();
  COPPICE_CHECK(policy.has_value() || is_refusal(policy.error()));
  if (!given) {
    COPPICE_CHECK(is_refusal(given.error()));
    return;
  }
  COPPICE_CHECK(given->q.size() == 4 && given->policy.size() == 2 && index_of(given->policy[1]) == 0);
  for (const double q : given->q) {
    COPPICE_CHECK(!std::isinf(q));
  }
  COPPICE_CHECK(!forbid(*given, model).has_value() || model.row_begin.back() == model.successor.size());
}

}  // namespace
}  // namespace coppice::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  coppice::fuzz::test(coppice::fuzz::as_text(data, size));
  return 0;
}
