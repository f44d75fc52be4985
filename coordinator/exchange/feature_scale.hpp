// Readings of a source turned into a feature of a vocabulary: legal names, values of a byte, bins.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "common/tree/vocabulary.hpp"
#include "coordinator/exchange/problem_file.hpp"
#include "coordinator/problem/problem.hpp"

namespace coppice {

// The distinct readings of one feature, as far as they are few.
class DistinctReadings {
 public:
  void add(double reading) {
    if (!too_many_ && reading != last_) {
      last_ = reading;
      insert(reading);
    }
  }
  bool too_many() const { return too_many_; }                 // more than kMaxValues
  const std::set<double>& values() const { return values_; }  // all of them, unless too_many()

 private:
  void insert(double reading);

  std::set<double> values_;
  double last_ = -1e308;
  bool too_many_ = false;
};

// Names as a vocabulary wants them, in the order given: foreign characters become _, a digit or nothing at the front
// gets `prefix` before it, reserved and repeated names get a number behind.
std::vector<std::string> legal_names(const std::vector<std::string>& names, const std::string& prefix);

// What makes edges where a feature has to be binned: quantiles or entropy over the readings, whoever has them.
using EdgesOf = std::function<Result<std::vector<double>>(const Binning&)>;

// A feature of the readings. Without a wish: up to kMaxValues distinct readings are values each (plain where all are
// whole numbers from 0 to 255), with = and, beyond two, <=; more are binned as `otherwise` says. Errors name the
// feature.
Result<Feature> feature_of(const std::string& name, const DistinctReadings& distinct, const FeatureWish& wish,
                           const Binning& otherwise, const EdgesOf& edges_of);

// The legend of a wish. Errors: a label for what the feature does not read.
Result<FeatureLegend> legend_of(const Feature& feature, const FeatureWish& wish);

}  // namespace coppice
