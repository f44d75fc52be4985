// read_problem_file(): a user's TOML about a problem, and the tests in it.
#include "coordinator/exchange/problem_file.hpp"

#include "coordinator/exchange/predicate.hpp"
#include "tests/fuzz/memory_file.hpp"
#include "tests/fuzz/target.hpp"

namespace coppice::fuzz {
namespace {

void test(std::string_view bytes) {
  const MemoryFile file(bytes);
  const auto problem = read_problem_file(file.path());
  accepted = problem.has_value();
  if (!problem) {
    COPPICE_CHECK(is_refusal(problem.error()));
    return;
  }
  COPPICE_CHECK(!problem->discount || (*problem->discount >= 0.0 && *problem->discount <= 1.0));
  for (const StateChoice* choice : {&problem->collisions, &problem->terminals, &problem->initial}) {
    const auto predicate = Predicate::parse(choice->when, {"x", "y"});
    COPPICE_CHECK(predicate.has_value() || is_refusal(predicate.error()));
  }
}

}  // namespace
}  // namespace coppice::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  coppice::fuzz::test(coppice::fuzz::as_text(data, size));
  return 0;
}
