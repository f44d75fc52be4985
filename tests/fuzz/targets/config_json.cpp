// config_from_json(), the configuration that a study holds: refused, or a configuration (configuration.hpp).
#include "common/check.hpp"
#include "tests/fuzz/configuration.hpp"
#include "tests/fuzz/target.hpp"

namespace coppice::fuzz {
namespace {

void test(std::string_view json) {
  const auto config = config_from_json(json);
  accepted = config.has_value();
  if (!config) {
    COPPICE_CHECK(is_refusal(config.error()));
    return;
  }
  check_configuration(*config);
}

}  // namespace
}  // namespace coppice::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  coppice::fuzz::test(coppice::fuzz::as_text(data, size));
  return 0;
}
