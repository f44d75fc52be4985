#include "coordinator/trust/verification.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <span>

#include "common/chain/best_return.hpp"
#include "common/chain/count_posterior.hpp"
#include "common/chain/exact.hpp"
#include "common/chain/exact_events.hpp"
#include "coordinator/learning/world.hpp"
#include "coordinator/report/on_chain.hpp"

namespace coppice {
namespace {

constexpr double kNormal95 = 1.96;  // the 97.5 % quantile of the standard normal distribution
constexpr double kLow = 0.025;
constexpr double kHigh = 0.975;
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();  // this draw gave no answer

// All figures of one set of probabilities.
struct Answers {
  double reward = 0.0;
  double reward_per_step = kUnknown;
  struct OfEvent {
    double within = 0.0;
    double ever = kUnknown;
    double steps = kUnknown;
  };
  std::vector<OfEvent> events;
};

// Rounding must not show a probability of more than 1.
double probability(double sum) { return std::min(sum, 1.0); }

class Model {
 public:
  Model(const Chain& chain, const Tree& tree, std::uint32_t steps)
      : chain_(chain), steps_(steps), solvable_(chain.states() <= kMaxSolvedStates), exact_(chain), events_(chain) {
    actions_ = actions_of(chain, tree);
    for (std::size_t state = 0; state < actions_.size(); ++state) {  // of interest here is what takes place
      actions_[state] = static_cast<std::uint8_t>(chain.taken(state, actions_[state]));
    }
    probabilities_.resize(chain.transitions());
    events_.begin(acting());
    reached_ = events_.states().size();
  }

  std::size_t reached() const { return reached_; }
  bool solvable() const { return solvable_; }
  std::size_t row(std::size_t state) const { return state * chain_.actions() + actions_[state]; }
  bool acts(std::size_t state) const { return actions_[state] < chain_.actions(); }
  bool untried(std::size_t state) const { return acts(state) && chain_.tries(row(state)) == 0; }

  // An event's probability in each state, under the tree's action.
  std::vector<double> under_tree(const EventPairs& pairs) const {
    std::vector<double> chance(chain_.states(), 0.0);
    for (std::size_t state = 0; state < chance.size(); ++state) {
      chance[state] = pairs.chance[state * (chain_.actions() + 1) + actions_[state]];
    }
    return chance;
  }

  // Under the tree, of every state that has them: what a draw is about.
  std::vector<std::size_t> tried_rows() const {
    std::vector<std::size_t> rows;
    for (std::size_t state = 0; state < chain_.states(); ++state) {
      if (acts(state) && !untried(state)) {
        rows.push_back(row(state));
      }
    }
    return rows;
  }

  std::span<double> probabilities() { return probabilities_; }

  // With the counts as they are, or with probabilities().
  Answers answer(const std::vector<std::vector<double>>& chances, bool drawn) {
    const std::span<const double> probabilities = drawn ? probabilities_ : std::span<const double>();
    Answers answers;
    exact_.set_probabilities(probabilities);
    answers.reward = reward_of(exact_.over_steps(acting(), steps_));
    if (solvable_) {
      if (const Occupancy* occupancy = exact_.long_run(acting()); occupancy != nullptr) {
        answers.reward_per_step = reward_of(*occupancy);
      }
    }
    events_.begin(acting(), probabilities);
    for (const std::vector<double>& chance : chances) {
      Answers::OfEvent& answer = answers.events.emplace_back();
      answer.within = probability(events_.within(chance, steps_));
      if (!solvable_) {
        continue;
      }
      if (const std::optional<FirstEvent> first = events_.ever(chance); first) {
        answer.ever = probability(first->probability);
        answer.steps = first->probability > 0.0 ? first->steps : kUnknown;
      }
    }
    return answers;
  }

 private:
  ActingTables acting() const { return {.actions = actions_, .others = {}, .others_share = 0.0}; }

  double reward_of(const Occupancy& occupancy) const {
    double reward = 0.0;
    for (std::size_t i = 0; i < occupancy.states.size(); ++i) {
      const std::size_t state = occupancy.states[i];
      reward += acts(state) ? occupancy.visits[i] * chain_.mean_reward(row(state)) : 0.0;
    }
    return reward;
  }

  const Chain& chain_;
  std::uint32_t steps_;
  bool solvable_;
  std::vector<std::uint8_t> actions_;
  std::vector<double> probabilities_;
  ExactOccupancy exact_;
  ExactEvents events_;
  std::size_t reached_ = 0;
};

// The empirical quantile: the smallest sample that at least a share q of the samples do not exceed.
double quantile(const std::vector<double>& sorted, double q) {
  const double rank = std::ceil(q * static_cast<double>(sorted.size()));
  return sorted[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
}

// No answer in the value: no figure. The draws are of what the counts leave open, and where hardly any draw went as far
// as the counts themselves do, their quantiles would leave those out: the interval always holds its value.
std::optional<Figure> figure(double value, std::vector<double> samples) {
  samples.erase(std::remove_if(samples.begin(), samples.end(), [](double x) { return std::isnan(x); }), samples.end());
  if (std::isnan(value) || samples.empty()) {
    return std::nullopt;
  }
  std::sort(samples.begin(), samples.end());
  return Figure{value, std::min(value, quantile(samples, kLow)), std::max(value, quantile(samples, kHigh))};
}

template <typename Part>
std::vector<double> parts(const std::vector<Answers>& draws, const Part& part) {
  std::vector<double> result;
  result.reserve(draws.size());
  for (const Answers& draw : draws) {
    result.push_back(part(draw));
  }
  return result;
}

void fill_figures(EventFigures& figures, std::size_t index, const Answers& found, const std::vector<Answers>& draws) {
  const Answers::OfEvent& value = found.events[index];
  figures.within = *figure(value.within, parts(draws, [&](const Answers& a) { return a.events[index].within; }));
  figures.ever = figure(value.ever, parts(draws, [&](const Answers& a) { return a.events[index].ever; }));
  figures.steps = figure(value.steps, parts(draws, [&](const Answers& a) { return a.events[index].steps; }));
}

}  // namespace

Result<void> check_settings(const VerifySettings& settings) {
  if (settings.steps < 1 || settings.steps > kMaxEpisodeSteps) {
    return bad_input(fmt::format("--steps is {}: expected 1 to {}", settings.steps, kMaxEpisodeSteps));
  }
  if (settings.resamples < kFewestResamples || settings.resamples > kMostResamples) {
    return bad_input(
        fmt::format("--resamples is {}: expected {} to {}", settings.resamples, kFewestResamples, kMostResamples));
  }
  return {};
}

Result<Verification> verify(const Chain& chain, const Tree& tree, const std::vector<Event>& events,
                            const std::vector<double>& world_rewards, const VerifySettings& settings,
                            const std::function<bool(std::uint32_t)>& go_on) {
  Model model(chain, tree, settings.steps);
  Verification result;
  result.settings = settings;
  result.states = chain.states();
  result.reached = model.reached();
  std::vector<std::uint8_t> policy;
  policy.reserve(chain.states());
  for (std::size_t state = 0; state < chain.states(); ++state) {
    policy.push_back(static_cast<std::uint8_t>(index_of(chain.policy(state))));
  }
  result.policy_reward = return_of(chain, policy, settings.steps);
  if (chain.states() <= kMaxSolvedStates) {
    result.most_reward = best_return(chain, settings.steps);
  }
  std::vector<std::vector<double>> chances;
  for (const Event& event : events) {
    const EventPairs pairs = pairs_of(event, chain, world_rewards);
    chances.push_back(model.under_tree(pairs));
    result.events.push_back({.name = event.name,
                             .test = to_text(event),
                             .pairs = pairs.pairs,
                             .unclear = pairs.unclear,
                             .within = {},
                             .ever = {},
                             .steps = {}});
  }
  // Leaving: by an untried pair; or also by a successor never seen, whose chance a draw makes anew below.
  const std::size_t untried = chances.size();
  const std::size_t unseen = untried + 1;
  result.untried.name = "untried";
  result.untried.test = "an action never tried there";
  result.unseen.name = "unseen";
  result.unseen.test = "that, or a successor never seen there";
  chances.resize(unseen + 1, std::vector<double>(chain.states(), 0.0));
  for (std::size_t state = 0; state < chain.states(); ++state) {
    if (model.untried(state)) {
      chances[untried][state] = chances[unseen][state] = 1.0;
      ++result.untried.pairs;
    } else if (model.acts(state)) {
      chances[unseen][state] = missing_mass(chain, model.row(state));
      result.unseen.pairs += chances[unseen][state] > 0.0 ? 1U : 0U;
    }
  }
  result.unseen.pairs += result.untried.pairs;
  const Answers found = model.answer(chances, false);

  const std::vector<std::size_t> rows = model.tried_rows();
  const std::vector<double> estimated = chances[unseen];
  CountPosterior posterior(chain, settings.seed);
  std::vector<Answers> draws;
  for (std::uint32_t i = 0; i < settings.resamples; ++i) {
    if (go_on && !go_on(i)) {
      return interrupted();
    }
    posterior.draw(rows, model.probabilities());
    for (const std::size_t row : rows) {
      const std::size_t state = row / chain.actions();
      if (estimated[state] > 0.0 && estimated[state] < 1.0) {
        // Of N tries, N m were the only one of their kind: Beta(N m, N (1 - m)), as two gammas.
        const auto tries = static_cast<double>(chain.tries(row));
        const double once = std::round(tries * estimated[state]);
        const double part = posterior.gamma(once);
        chances[unseen][state] = part / (part + posterior.gamma(tries - once));
      }
    }
    draws.push_back(model.answer(chances, true));
  }
  result.reward = *figure(found.reward, parts(draws, [](const Answers& a) { return a.reward; }));
  result.reward_per_step =
      figure(found.reward_per_step, parts(draws, [](const Answers& a) { return a.reward_per_step; }));
  for (std::size_t i = 0; i < events.size(); ++i) {
    fill_figures(result.events[i], i, found, draws);
  }
  fill_figures(result.untried, untried, found, draws);
  fill_figures(result.unseen, unseen, found, draws);
  return result;
}

Figure wilson(std::uint64_t successes, std::uint64_t trials) {
  const auto n = static_cast<double>(trials);
  const double p = static_cast<double>(successes) / n;
  const double z2 = kNormal95 * kNormal95;
  const double centre = (p + z2 / (2.0 * n)) / (1.0 + z2 / n);
  const double margin = kNormal95 / (1.0 + z2 / n) * std::sqrt(p * (1.0 - p) / n + z2 / (4.0 * n * n));
  return {p, successes == 0 ? 0.0 : centre - margin, successes == trials ? 1.0 : centre + margin};
}

Simulated sum_up(const std::vector<EpisodeRecord>& records) {
  Simulated result;
  result.episodes = records.size();
  const auto n = static_cast<double>(records.size());
  std::uint64_t collided = 0;
  std::uint64_t lost = 0;
  double sum = 0.0;
  double squares = 0.0;
  for (const EpisodeRecord& record : records) {
    collided += record.collisions > 0 ? 1U : 0U;
    lost += record.unknown > 0 ? 1U : 0U;
    sum += record.reward;
  }
  const double mean = sum / n;
  for (const EpisodeRecord& record : records) {
    squares += (record.reward - mean) * (record.reward - mean);
  }
  const double margin = records.size() < 2 ? 0.0 : kNormal95 * std::sqrt(squares / (n - 1.0) / n);
  result.collision = wilson(collided, records.size());
  result.unknown = wilson(lost, records.size());
  result.reward = {mean, mean - margin, mean + margin};
  return result;
}

}  // namespace coppice
