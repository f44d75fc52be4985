#include "common/evolution/edit_sums.hpp"

#include <algorithm>

#include "common/tree/condition.hpp"

namespace coppice {
namespace {

// kSums: how many, known to the compiler, which becomes vector instructions; 0: `sums`.
template <std::size_t kSums>
void add(const double* row, double* to, std::size_t sums) {
  const std::size_t count = kSums > 0 ? kSums : sums;
  for (std::size_t k = 0; k < count; ++k) {
    to[k] += row[k];
  }
}

}  // namespace

ValueSlots::ValueSlots(const Chain& chain) : first(1, 0) {
  const Vocabulary& vocabulary = chain.vocabulary();
  for (const Feature& feature : vocabulary.features) {
    first.push_back(first.back() + static_cast<std::uint32_t>(feature.values.size()));
  }
  slot.reserve(chain.states() * vocabulary.features.size());
  for (std::size_t s = 0; s < chain.states(); ++s) {
    for (std::size_t f = 0; f < vocabulary.features.size(); ++f) {
      const std::vector<std::uint8_t>& values = vocabulary.features[f].values;
      const auto found = std::lower_bound(values.begin(), values.end(), chain.features_of(s)[f]);
      slot.push_back(first[f] + static_cast<std::uint32_t>(found - values.begin()));
    }
  }
}

EditSums::EditSums(const Chain& chain, const ValueSlots& slots, std::span<const double> gains,
                   std::span<const std::uint32_t> states)
    : chain_(chain),
      slots_(slots),
      gains_(gains),
      states_(states),
      stride_(chain.actions() + 1),
      sums_(kWrites + chain.actions()) {}

// Nothing where nothing changes: most states, at most places.
void EditSums::add_row(std::size_t m, const EditPlaces::Outcome& outcome, std::uint8_t now) {
  const double* const gain = gains_.data() + states_[m] * stride_;
  const double so_far = gain[now];
  const std::size_t begin = rows_.size();
  rows_.resize(begin + sums_);
  double* const row = rows_.data() + begin;
  row[kFails] = gain[outcome.on_failure] - so_far;
  row[kSucceeds] = gain[outcome.on_success] - so_far;
  for (std::size_t k = kWrites; k < sums_; ++k) {
    row[k] = outcome.overwritten ? row[kSucceeds] : gain[k - kWrites] - so_far;
  }
  if (std::all_of(row, row + sums_, [](double value) { return value == 0.0; })) {
    rows_.resize(begin);
  } else {
    states_here_.push_back(static_cast<std::uint32_t>(m));
  }
}

void EditSums::sum_up() {
  switch (sums_) {
    case 4:
      return sum_up_sums<4>();
    case 5:
      return sum_up_sums<5>();
    case 6:
      return sum_up_sums<6>();
    case 7:
      return sum_up_sums<7>();
    case 8:
      return sum_up_sums<8>();
    default:
      return sum_up_sums<0>();
  }
}

template <std::size_t kSums>
void EditSums::sum_up_sums() {
  total_.assign(sums_, 0.0);
  by_value_.assign(std::size_t{slots_.first.back()} * sums_, 0.0);
  const std::size_t features = slots_.first.size() - 1;
  for (std::size_t i = 0; i < states_here_.size(); ++i) {
    const double* const row = rows_.data() + i * sums_;
    add<kSums>(row, total_.data(), sums_);
    const std::uint32_t* const slots = slots_.slot.data() + states_[states_here_[i]] * features;
    for (std::size_t f = 0; f < features; ++f) {
      add<kSums>(row, by_value_.data() + std::size_t{slots[f]} * sums_, sums_);
    }
  }
}

EditSums EditSums::where(const Node& condition) const {
  EditSums part(chain_, slots_, gains_, states_);
  for (std::size_t i = 0; i < states_here_.size(); ++i) {
    if (holds(condition, chain_.features_of(states_[states_here_[i]]))) {
      part.states_here_.push_back(states_here_[i]);
      part.rows_.insert(part.rows_.end(), rows_.begin() + static_cast<std::ptrdiff_t>(i * sums_),
                        rows_.begin() + static_cast<std::ptrdiff_t>((i + 1) * sums_));
    }
  }
  part.sum_up();
  return part;
}

}  // namespace coppice
