#include "common/evolution/front_individual.hpp"

#include <algorithm>
#include <limits>

#include "common/evolution/dominance.hpp"

namespace coppice {

std::vector<double> costs_of(const std::vector<FrontIndividual>& individuals) {
  std::vector<double> costs;
  costs.reserve(individuals.empty() ? 0 : individuals.size() * individuals.front().costs.size());
  for (const FrontIndividual& individual : individuals) {
    costs.insert(costs.end(), individual.costs.begin(), individual.costs.end());
  }
  return costs;
}

void keep_best(std::vector<FrontIndividual>& individuals, std::size_t costs, std::size_t count) {
  const std::vector<double> values = costs_of(individuals);
  std::vector<std::size_t> kept = survivors({values, costs}, count);
  std::sort(kept.begin(), kept.end());
  std::vector<FrontIndividual> next;
  next.reserve(count);
  for (const std::size_t i : kept) {
    next.push_back(std::move(individuals[i]));
  }
  individuals = std::move(next);
}

std::vector<double> random_weights(Stream& stream, std::size_t count) {
  constexpr std::uint64_t kParts = 1U << 20U;
  std::vector<double> cuts = {0.0, 1.0};
  for (std::size_t i = 1; i < count; ++i) {
    cuts.push_back(static_cast<double>(stream.below(kParts)) / static_cast<double>(kParts));
  }
  std::sort(cuts.begin(), cuts.end());
  std::vector<double> weights(count);
  for (std::size_t i = 0; i < count; ++i) {
    weights[i] = cuts[i + 1] - cuts[i];
  }
  return weights;
}

ParentPool::ParentPool(const std::vector<FrontIndividual>& individuals, std::size_t costs) : individuals_(individuals) {
  const std::vector<double> values = costs_of(individuals);
  const Costs all{values, costs};
  Standing standing = standing_of(all);
  ranks_ = std::move(standing.ranks);
  crowding_ = std::move(standing.crowding);
  low_.assign(costs, std::numeric_limits<double>::max());
  high_.assign(costs, std::numeric_limits<double>::lowest());
  for (std::size_t i = 0; i < individuals.size(); ++i) {
    for (std::size_t c = 0; c < costs && ranks_[i] == 0; ++c) {
      low_[c] = std::min(low_[c], all.of(i)[c]);
      high_[c] = std::max(high_[c], all.of(i)[c]);
    }
  }
}

const FrontIndividual& ParentPool::by_crowding(Stream& stream) const {
  const std::size_t a = stream.below(individuals_.size());
  const std::size_t b = stream.below(individuals_.size());
  const bool second = ranks_[b] != ranks_[a] ? ranks_[b] < ranks_[a] : crowding_[b] > crowding_[a];
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
  double sum = 0.0;
  for (std::size_t c = 0; c < weights.size(); ++c) {
    const double range = high_[c] - low_[c];
    sum += range > 0.0 ? weights[c] * (individuals_[i].costs[c] - low_[c]) / range : 0.0;
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
    std::vector<FrontIndividual> members = std::move(members_);
    keep_best(members, costs, count);
    assign(std::move(members));
  }
}

}  // namespace coppice
