// population_from_text(), a checkpoint in a study: whatever it accepts has the fitness that is written there, fit to be
// ranked, and trees of the vocabulary, and reads back the same bits.
#include "coordinator/study/checkpoint_text.hpp"

#include <bit>
#include <cmath>
#include <cstdlib>
#include <string>

#include "common/check.hpp"
#include "tests/fuzz/target.hpp"
#include "tests/fuzz/words.hpp"

namespace coppice::fuzz {
namespace {

// The C library's reading of a whole field, another than the code's own.
bool spells(const std::string& field, double value) {
  char* end = nullptr;
  const double read = std::strtod(field.c_str(), &end);
  return !field.empty() && end == field.c_str() + field.size() &&
         std::bit_cast<std::uint64_t>(read) == std::bit_cast<std::uint64_t>(value);
}

void check_fields(std::string_view text, const FitTrees& population) {
  for (std::size_t slot = 0; slot < population.fitness.size(); ++slot) {
    COPPICE_CHECK(std::isfinite(population.fitness[slot]));  // ranking() requires that none is NaN
    COPPICE_CHECK(spells(std::string(text.substr(0, text.find('\t'))), population.fitness[slot]));
    text.remove_prefix(text.find('\n') + 1);
  }
  COPPICE_CHECK(text.empty());
}

void test(std::string_view text) {
  const auto population = population_from_text(text, words());
  accepted = population.has_value();
  if (!population) {
    COPPICE_CHECK(is_printable_refusal(population.error()));
    return;
  }
  COPPICE_CHECK(population->trees.size() == population->fitness.size());
  for (const Tree& tree : population->trees) {
    COPPICE_CHECK(check_tree(tree, words()).has_value());
  }
  check_fields(text, *population);
  const auto again = population_from_text(population_text(*population, words()), words());
  COPPICE_CHECK(again.has_value() && again->trees == population->trees);
  for (std::size_t slot = 0; slot < population->fitness.size(); ++slot) {
    COPPICE_CHECK(std::bit_cast<std::uint64_t>(again->fitness[slot]) ==
                  std::bit_cast<std::uint64_t>(population->fitness[slot]));
  }
}

}  // namespace
}  // namespace coppice::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  coppice::fuzz::test(coppice::fuzz::as_text(data, size));
  return 0;
}
