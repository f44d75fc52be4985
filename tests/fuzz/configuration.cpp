#include "tests/fuzz/configuration.hpp"

#include <utility>

#include "common/check.hpp"
#include "tests/fuzz/target.hpp"
#include "tests/fuzz/words.hpp"

namespace coppice::fuzz {

void check_configuration(const EvolveConfig& config) {
  const auto read = config_from_json(config_to_json(config));
  COPPICE_CHECK(read.has_value() && *read == config);
  if (auto ok = check_config(config, words()); !ok) {
    COPPICE_CHECK(is_refusal(ok.error()));
    return;
  }
  auto objectives = objectives_of(config.fitness, words());
  COPPICE_CHECK(objectives.has_value());
  COPPICE_CHECK(check_job(job_of(config, *objectives, 0)).has_value());
  COPPICE_CHECK(check_job(job_of(config, std::move(*objectives), kFinalGeneration)).has_value());
}

}  // namespace coppice::fuzz
