#include "common/evolution/front_individual.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "common/check.hpp"
#include "common/evolution/measure.hpp"

namespace coppice {

std::vector<double> costs_of(const std::vector<FrontIndividual>& individuals) {
  std::vector<double> costs;
  costs.reserve(individuals.empty() ? 0 : individuals.size() * individuals.front().costs.size());
  for (const FrontIndividual& individual : individuals) {
    costs.insert(costs.end(), individual.costs.begin(), individual.costs.end());
  }
  return costs;
}

namespace {

// REQUIRES: ascending.
void keep_only(std::vector<FrontIndividual>& individuals, std::span<const std::size_t> kept) {
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (kept[i] != i) {
      individuals[i] = std::move(individuals[kept[i]]);
    }
  }
  individuals.resize(kept.size());
}

}  // namespace

Standing keep_best(std::vector<FrontIndividual>& individuals, std::size_t costs, std::size_t count) {
  const std::vector<double> values = costs_of(individuals);
  Survivors survivors = survivors_of({values, costs}, count);
  keep_only(individuals, survivors.points);
  return std::move(survivors.standing);
}

void draw_weights(Stream& stream, std::span<double> weights) {
  constexpr std::uint64_t kParts = 1U << 20U;
  COPPICE_CHECK(!weights.empty() && weights.size() <= kMeasures);
  std::array<double, kMeasures + 1> cuts;
  cuts[0] = 0.0;
  for (std::size_t i = 1; i < weights.size(); ++i) {
    cuts[i] = static_cast<double>(stream.below(kParts)) / static_cast<double>(kParts);
  }
  std::sort(cuts.begin(), cuts.begin() + std::ssize(weights));
  cuts[weights.size()] = 1.0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    weights[i] = cuts[i + 1] - cuts[i];
  }
}

ParentPool::ParentPool(const std::vector<FrontIndividual>& individuals, std::size_t costs, const Standing* standing)
    : individuals_(individuals),
      standing_(standing),
      values_(costs_of(individuals)),
      low_(costs, std::numeric_limits<double>::max()),
      high_(costs, std::numeric_limits<double>::lowest()) {
  for (std::size_t i = 0; i < individuals.size(); ++i) {
    if (standing_ != nullptr && standing_->ranks[i] != 0) {
      continue;
    }
    for (std::size_t c = 0; c < costs; ++c) {
      low_[c] = std::min(low_[c], values_[i * costs + c]);
      high_[c] = std::max(high_[c], values_[i * costs + c]);
    }
  }
}

const FrontIndividual& ParentPool::by_crowding(Stream& stream) const {
  const std::size_t a = stream.below(individuals_.size());
  const std::size_t b = stream.below(individuals_.size());
  const std::vector<std::uint32_t>& ranks = standing_->ranks;
  const bool second = ranks[b] != ranks[a] ? ranks[b] < ranks[a] : standing_->crowding[b] > standing_->crowding[a];
  return individuals_[second ? b : a];
}

const FrontIndividual& ParentPool::by_weights(Stream& stream, std::span<const double> weights, std::size_t size) const {
  std::size_t winner = stream.below(individuals_.size());
  double least = weighted(winner, weights);
  for (std::size_t i = 1; i < size; ++i) {
    const std::size_t rival = stream.below(individuals_.size());
    if (const double sum = weighted(rival, weights); sum < least) {
      winner = rival;
      least = sum;
    }
  }
  return individuals_[winner];
}

std::vector<double> ParentPool::by_range(std::span<const double> weights) const {
  std::vector<double> result(weights.begin(), weights.end());
  for (std::size_t c = 0; c < result.size(); ++c) {
    const double range = high_[c] - low_[c];
    result[c] = range > 0.0 ? result[c] / range : result[c];
  }
  return result;
}

double ParentPool::weighted(std::size_t i, std::span<const double> weights) const {
  const double* const costs = values_.data() + i * weights.size();
  double sum = 0.0;
  for (std::size_t c = 0; c < weights.size(); ++c) {
    const double range = high_[c] - low_[c];
    sum += range > 0.0 ? weights[c] * (costs[c] - low_[c]) / range : 0.0;
  }
  return sum;
}

namespace {

// In every cost at least as good.
bool as_good(const double* a, const double* b, std::size_t costs) {
  for (std::size_t c = 0; c < costs; ++c) {
    if (a[c] > b[c]) {
      return false;
    }
  }
  return true;
}

}  // namespace

void FrontArchive::assign(std::vector<FrontIndividual> members) {
  members_ = std::move(members);
  values_ = costs_of(members_);
  latest_ = 0;
}

void FrontArchive::offer(const FrontIndividual& candidate, std::size_t max_nodes) {
  if (candidate.tree.size() > max_nodes || candidate.tally.steps == 0) {
    return;
  }
  const std::size_t costs = candidate.costs.size();
  const double* const offered = candidate.costs.data();
  const auto of = [&](std::size_t member) { return values_.data() + member * costs; };
  // Who was better than the one before is likely to be better than this one.
  if (latest_ < members_.size() && as_good(of(latest_), offered, costs)) {
    return;
  }
  bool beats_some = false;
  for (std::size_t member = 0; member < members_.size(); ++member) {
    if (as_good(of(member), offered, costs)) {
      latest_ = member;
      return;
    }
    beats_some = beats_some || as_good(offered, of(member), costs);
  }
  if (beats_some) {
    std::size_t kept = 0;
    for (std::size_t member = 0; member < members_.size(); ++member) {
      if (!as_good(offered, of(member), costs)) {
        if (kept != member) {
          members_[kept] = std::move(members_[member]);
          std::copy_n(of(member), costs, values_.data() + kept * costs);
        }
        ++kept;
      }
    }
    members_.resize(kept);
    values_.resize(kept * costs);
  }
  members_.push_back(candidate);
  values_.insert(values_.end(), candidate.costs.begin(), candidate.costs.end());
}

void FrontArchive::thin(std::size_t costs, std::size_t count) {
  if (members_.size() > count) {
    keep_only(members_, survivors_of_front({values_, costs}, count).points);
    values_ = costs_of(members_);
    latest_ = 0;
  }
}

}  // namespace coppice
