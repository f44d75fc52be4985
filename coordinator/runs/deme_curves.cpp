#include "coordinator/runs/deme_curves.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "common/check.hpp"

namespace coppice {

void DemeCurves::add(std::span<const std::vector<GenerationRecord>> of_demes) {
  COPPICE_CHECK(!of_demes.empty() && (demes_.empty() || demes_.size() == of_demes.size()));
  demes_.resize(of_demes.size());
  // After a rollback generations come again.
  const std::uint32_t first = of_demes.front().front().generation;
  const auto kept =
      static_cast<std::size_t>(std::lower_bound(generation_.begin(), generation_.end(), first) - generation_.begin());
  generation_.resize(kept);
  for (std::vector<Point>& deme : demes_) {
    deme.resize(std::min(deme.size(), kept));
  }
  for (const GenerationRecord& record : of_demes.front()) {
    generation_.push_back(record.generation);
  }
  for (std::size_t deme = 0; deme < of_demes.size(); ++deme) {
    for (const GenerationRecord& record : of_demes[deme]) {
      demes_[deme].push_back(
          {record.best.fitness, record.mean_fitness, static_cast<double>(record.best_nodes()), record.mean_nodes});
    }
    COPPICE_CHECK(demes_[deme].size() == generation_.size());
  }
}

nlohmann::ordered_json DemeCurves::json() const {
  using Json = nlohmann::ordered_json;
  constexpr std::array<std::pair<const char*, double Point::*>, 4> kColumns{{{"best_fitness", &Point::best_fitness},
                                                                             {"mean_fitness", &Point::mean_fitness},
                                                                             {"best_nodes", &Point::best_nodes},
                                                                             {"mean_nodes", &Point::mean_nodes}}};
  const std::size_t every = (generation_.size() + kMostPoints - 1) / kMostPoints;
  Json json = {{"generation", Json::array()}, {"demes", Json::array()}};
  for (std::size_t deme = 0; deme < demes_.size(); ++deme) {
    Json columns = Json::object();
    for (const auto& [name, member] : kColumns) {
      columns[name] = Json::array();
    }
    for (std::size_t i = 0; i < generation_.size(); ++i) {
      if (i % every != 0 && i + 1 != generation_.size()) {
        continue;
      }
      if (deme == 0) {
        json["generation"].push_back(generation_[i]);
      }
      for (const auto& [name, member] : kColumns) {
        columns[name].push_back(demes_[deme][i].*member);
      }
    }
    json["demes"].push_back(std::move(columns));
  }
  return json;
}

}  // namespace coppice
