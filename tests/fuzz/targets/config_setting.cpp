// apply_setting(), as after --set: refused without a change, or a configuration (configuration.hpp).
#include "common/check.hpp"
#include "tests/fuzz/configuration.hpp"
#include "tests/fuzz/target.hpp"

namespace coppice::fuzz {
namespace {

void test(std::string_view assignment) {
  EvolveConfig config;
  const auto ok = apply_setting(assignment, config);
  accepted = ok.has_value();
  if (!ok) {
    COPPICE_CHECK(is_refusal(ok.error()) && config == EvolveConfig());
    return;
  }
  check_configuration(config);
}

}  // namespace
}  // namespace coppice::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  coppice::fuzz::test(coppice::fuzz::one_line(coppice::fuzz::as_text(data, size)));
  return 0;
}
