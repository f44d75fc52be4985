#include "coordinator/exchange/prism_explicit.hpp"

#include <fmt/format.h>

namespace coppice {
namespace {

void write_transitions(const MarkovModel& model, std::ostream& out) {
  out << (model.is_mdp() ? fmt::format("{} {} {}\n", model.states(), model.choices(), model.transitions())
                         : fmt::format("{} {}\n", model.states(), model.transitions()));
  std::vector<ModelChoice> choices;
  for (std::size_t state = 0; state < model.states(); ++state) {
    model.choices_of(state, choices);
    for (std::size_t k = 0; k < choices.size(); ++k) {
      for (const ModelTarget& target : choices[k].targets) {
        out << (model.is_mdp() ? fmt::format("{} {} {} {:.17g} {}\n", state, k, target.state, target.probability,
                                             choices[k].action)
                               : fmt::format("{} {} {:.17g}\n", state, target.state, target.probability));
      }
    }
  }
}

void write_states(const MarkovModel& model, std::ostream& out) {
  const Chain& chain = model.chain();
  out << '(';
  for (const Feature& feature : chain.vocabulary().features) {
    out << feature.name << ',';
  }
  out << "_kind)\n";  // 0: a state of the chain, 1: unknown, 2: start
  for (std::size_t state = 0; state < model.states(); ++state) {
    out << state << ":(";
    for (std::size_t f = 0; f < chain.vocabulary().features.size(); ++f) {
      // PRISM's variables are whole numbers: values with other names appear by their number.
      out << (state < chain.states() ? static_cast<unsigned>(chain.features_of(state)[f]) : 0U) << ',';
    }
    out << (state < chain.states() ? 0 : state == chain.states() ? 1 : 2) << ")\n";
  }
}

void write_labels(const MarkovModel& model, std::ostream& out) {
  // Numbers of "init" and "deadlock" are fixed.
  out << "0=\"init\" 1=\"deadlock\"";
  for (std::size_t i = 1; i < model.label_names().size(); ++i) {
    out << ' ' << i + 1 << "=\"" << model.label_names()[i] << '"';
  }
  out << '\n';
  for (std::size_t state = 0; state < model.states(); ++state) {
    const std::vector<std::size_t> labels = model.labels_of(state);
    if (labels.empty()) {
      continue;
    }
    out << state << ':';
    for (const std::size_t label : labels) {
      out << ' ' << (label == 0 ? 0 : label + 1);
    }
    out << '\n';
  }
}

// Calls visit(state, choice number, choice) for every choice whose reward is not 0.
template <typename Visit>
void for_each_prism_reward(const MarkovModel& model, PrismFile file, const Visit& visit) {
  std::vector<ModelChoice> choices;
  for (std::size_t state = 0; state < model.states(); ++state) {
    model.choices_of(state, choices);
    for (std::size_t k = 0; k < choices.size(); ++k) {
      const double reward = file == PrismFile::gain ? choices[k].gain : choices[k].cost;
      if (reward != 0.0) {
        visit(state, k, choices[k], reward);
      }
    }
  }
}

void write_rewards(const MarkovModel& model, PrismFile file, std::ostream& out) {
  std::uint64_t entries = 0;
  for_each_prism_reward(model, file, [&](std::size_t, std::size_t, const ModelChoice& choice, double) {
    entries += model.is_mdp() ? choice.targets.size() : 1;
  });
  out << (model.is_mdp() ? fmt::format("{} {} {}\n", model.states(), model.choices(), entries)
                         : fmt::format("{} {}\n", model.states(), entries));
  for_each_prism_reward(model, file, [&](std::size_t state, std::size_t k, const ModelChoice& choice, double reward) {
    if (!model.is_mdp()) {
      out << fmt::format("{} {:.17g}\n", state, reward);
      return;
    }
    for (const ModelTarget& target : choice.targets) {
      out << fmt::format("{} {} {} {:.17g}\n", state, k, target.state, reward);
    }
  });
}

}  // namespace

std::vector<PrismPart> prism_parts(const MarkovModel& model) {
  const std::string rewards = model.is_mdp() ? ".trew" : ".srew";
  return {{PrismFile::transitions, ".tra"},
          {PrismFile::states, ".sta"},
          {PrismFile::labels, ".lab"},
          {PrismFile::gain, ".gain" + rewards},
          {PrismFile::cost, ".cost" + rewards}};
}

void write_prism(const MarkovModel& model, PrismFile file, std::ostream& out) {
  switch (file) {
    case PrismFile::transitions:
      return write_transitions(model, out);
    case PrismFile::states:
      return write_states(model, out);
    case PrismFile::labels:
      return write_labels(model, out);
    case PrismFile::gain:
    case PrismFile::cost:
      return write_rewards(model, file, out);
  }
}

}  // namespace coppice
