#include "coordinator/evolution/config_text.hpp"

#include "coordinator/evolution/pick.hpp"

namespace coppice {

Result<void> check_config(const EvolveConfig& config, const Vocabulary& vocabulary) {
  if (auto ok = check_search(config, vocabulary); !ok) {
    return ok;
  }
  if (const auto rule = parse_pick(config.front.pick); !rule) {
    return in_context("front.pick", rule.error());
  }
  return {};
}

}  // namespace coppice
