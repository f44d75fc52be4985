#include "common/evolution/edit_pairs.hpp"

#include <algorithm>
#include <vector>

namespace coppice {
namespace {

// A condition, and the sums where it holds.
struct Conditional {
  Node condition;
  std::vector<double> where;
};

// What is kept of the sums: where both hold, where only the second does, where neither does.
struct Parts {
  std::vector<double> both;
  std::vector<double> second_only;
  std::vector<double> neither;
};

class PairRanking {
 public:
  PairRanking(const PairPlace& at, std::size_t actions, EditShortlist& shortlist)
      : at_(at), actions_(actions), shortlist_(shortlist) {}

  void offer_branches(const Node& first, const Node& second, const double* where_first, const Parts& parts) {
    for (std::size_t a = 0; a < actions_; ++a) {
      const std::size_t k = kWrites + a;
      const auto action = static_cast<std::uint8_t>(a);
      EditCandidate candidate = of(EditForm::both, 4, first, second);
      const double elsewhere =
          where_first[kFails] - parts.both[kFails] + parts.second_only[kFails] + parts.neither[kFails];
      candidate.gain += parts.both[k] + elsewhere;
      candidate.action = action;
      shortlist_.offer(candidate, at_.conditions + 2);
      candidate = of(EditForm::either, 5, first, second);
      candidate.gain += where_first[k] + parts.second_only[k] + parts.neither[kFails];
      candidate.action = action;
      shortlist_.offer(candidate, at_.conditions + 2);
    }
  }

  void offer_list(const Node& first, const Node& second, const double* where_first, const Parts& parts) {
    const std::size_t a = best_of(where_first);
    const std::size_t b = best_of(parts.second_only.data());
    const std::size_t e = best_of(parts.neither.data());
    if (a == b && b == e) {
      return;
    }
    EditCandidate candidate = of(EditForm::list, 8, first, second);
    candidate.gain += where_first[kWrites + a] + parts.second_only[kWrites + b] + parts.neither[kWrites + e];
    candidate.action = static_cast<std::uint8_t>(a);
    candidate.second = static_cast<std::uint8_t>(b);
    candidate.third = static_cast<std::uint8_t>(e);
    shortlist_.offer(candidate, at_.conditions + 2);
  }

 private:
  EditCandidate of(EditForm form, std::ptrdiff_t nodes, const Node& first, const Node& second) const {
    EditCandidate candidate = at_.place;
    candidate.form = form;
    candidate.gain = at_.base;
    candidate.nodes += nodes;
    candidate.condition = first;
    candidate.second_condition = second;
    return candidate;
  }

  // The action that gains most.
  std::size_t best_of(const double* sums) const {
    const double* const writes = sums + kWrites;
    return static_cast<std::size_t>(std::max_element(writes, writes + actions_) - writes);
  }

  const PairPlace& at_;
  std::size_t actions_;
  EditShortlist& shortlist_;
};

}  // namespace

void rank_pairs(EditSums& sums, const PairPlace& at, std::size_t actions, EditShortlist& shortlist) {
  const std::size_t size = kWrites + actions;
  std::vector<Conditional> all;
  sums.for_conditions([&](const Node& condition, const double* where) {
    all.push_back({condition, {where, where + size}});
  });
  PairRanking ranking(at, actions, shortlist);
  Parts parts;
  parts.second_only.resize(size);
  parts.neither.resize(size);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Conditional& first = all[i];
    EditSums part = sums.where(first.condition);
    std::size_t j = 0;
    part.for_conditions([&](const Node& condition, const double* both) {
      const Conditional& second = all[j];
      ++j;
      if (condition.index == first.condition.index) {
        return;
      }
      parts.both.assign(both, both + size);
      for (std::size_t k = 0; k < size; ++k) {
        parts.second_only[k] = second.where[k] - both[k];
        parts.neither[k] = sums.total()[k] - first.where[k] - parts.second_only[k];
      }
      if (at.forms.branch && j - 1 > i) {
        ranking.offer_branches(first.condition, condition, first.where.data(), parts);
      }
      if (at.forms.list) {
        ranking.offer_list(first.condition, condition, first.where.data(), parts);
      }
    });
  }
}

}  // namespace coppice
