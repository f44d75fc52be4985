#include "tests/coordinator/study/study_fixture.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace coppice::testing {

Study StudyFiles::make() {
  auto study = Study::create(path_, chain_, world_, learning_);
  if (!study) {
    throw std::runtime_error(study.error().message);
  }
  return std::move(*study);
}

Study StudyFiles::reopen(Study closed) const {
  const std::string path = closed.path();
  { const Study gone = std::move(closed); }
  auto study = Study::open(path);
  if (!study) {
    throw std::runtime_error(study.error().message);
  }
  return std::move(*study);
}

EvolveConfig StudyFiles::config() {
  EvolveConfig config;
  config.ga.generations = 8;
  config.ga.population = 20;
  config.rollout.rollouts = 2;
  config.rollout.steps = 20;
  config.rollout.final_rollouts = 4;
  return config;
}

EvolveHooks StudyFiles::saving_hooks(Study& study, RunId run) {
  return {[&study, run](std::span<const GenerationRecord> records, const Checkpoint& checkpoint) {
    return study.save_generations(run, records, checkpoint);
  }};
}

std::vector<GenerationRecord> StudyFiles::evolve_into(Study& study, RunId run, const EvolveConfig& config) {
  std::vector<GenerationRecord> all;
  WalkingEvaluator evaluator(chain_);
  const EvolveHooks hooks{[&](std::span<const GenerationRecord> records, const Checkpoint& checkpoint) {
    all.insert(all.end(), records.begin(), records.end());
    return study.save_generations(run, records, checkpoint);
  }};
  const auto evolved = evolve(chain_, config, evaluator, std::nullopt, hooks);
  if (!evolved) {
    throw std::runtime_error(evolved.error().message);
  }
  return all;
}

std::string StudyFiles::content() const {
  std::ifstream file(path_, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void StudyFiles::overwrite(std::string_view bytes) {
  std::ofstream file(path_, std::ios::binary | std::ios::trunc);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

std::vector<std::string> StudyFiles::files() const {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
    names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace coppice::testing
