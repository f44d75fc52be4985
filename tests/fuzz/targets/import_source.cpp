// import_source(): models, tables and logs of other tools, the format told from the content. Whatever is accepted is a
// chain with its problem, and the chain's bytes are those that it is read back from.
#include "coordinator/exchange/import_source.hpp"

#include <cmath>

#include "common/chain/chain_bytes.hpp"
#include "tests/fuzz/memory_file.hpp"
#include "tests/fuzz/target.hpp"

namespace coppice::fuzz {
namespace {

void test(std::string_view bytes) {
  const MemoryFile file(bytes);
  ImportSettings settings;
  settings.source = file.path();
  settings.solve = true;
  settings.gamma = 0.5;
  const auto imported = import_source(settings);
  accepted = imported.has_value();
  if (!imported) {
    COPPICE_CHECK(is_refusal(imported.error()));
    return;
  }
  COPPICE_CHECK(imported->report.value.has_value() && std::isfinite(*imported->report.value));
  const auto read = chain_from_bytes(to_bytes(imported->chain));
  COPPICE_CHECK(read.has_value() && read->parts() == imported->chain.parts());
  const auto problem = problem_from_json(to_json(imported->problem, read->vocabulary()), read->vocabulary());
  COPPICE_CHECK(problem.has_value());
}

}  // namespace
}  // namespace coppice::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  coppice::fuzz::test(coppice::fuzz::as_text(data, size));
  return 0;
}
