#include "coordinator/evolution/front_individual.hpp"

#include <algorithm>
#include <limits>

#include "coordinator/evolution/dominance.hpp"

namespace coppice {

std::vector<double> costs_of(const std::vector<FrontIndividual>& individuals) {
  std::vector<double> costs;
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
  ranks_ = ranks_of(all);
  crowding_ = crowding_of(all, ranks_);
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

double ParentPool::weighted(std::size_t i, std::span<const double> weights) const {
  double sum = 0.0;
  for (std::size_t c = 0; c < weights.size(); ++c) {
    const double range = high_[c] - low_[c];
    sum += range > 0.0 ? weights[c] * (individuals_[i].costs[c] - low_[c]) / range : 0.0;
  }
  return sum;
}

void FrontArchive::offer(const FrontIndividual& candidate, std::size_t max_nodes) {
  if (candidate.tree.size() > max_nodes || candidate.tally.steps == 0) {
    return;
  }
  for (const FrontIndividual& member : members_) {
    if (member.costs == candidate.costs || dominates(member.costs, candidate.costs)) {
      return;
    }
  }
  members_.erase(
      std::remove_if(members_.begin(), members_.end(),
                     [&](const FrontIndividual& member) { return dominates(candidate.costs, member.costs); }),
      members_.end());
  members_.push_back(candidate);
}

}  // namespace coppice
