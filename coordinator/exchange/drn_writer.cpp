#include "coordinator/exchange/drn_writer.hpp"

#include <fmt/format.h>
#include <iterator>

namespace coppice {
namespace {

// 17 digits: every double comes back as it was.
void append_number(std::string& text, double number) { fmt::format_to(std::back_inserter(text), "{:.17g}", number); }

// Plain numbers in interval models, too: Storm reads no others.
void append_rewards(std::string& text, double gain, double cost) {
  text += '[';
  append_number(text, gain);
  text += ", ";
  append_number(text, cost);
  text += ']';
}

}  // namespace

void write_drn(const MarkovModel& model, bool intervals, std::ostream& out) {
  const Chain& chain = model.chain();
  out << "// Written by coppice\n@type: " << (model.is_mdp() ? "MDP" : "DTMC")
      << "\n@value_type: " << (intervals ? "double-interval" : "double")
      << "\n@parameters\n\n@reward_models\ngain cost\n@nr_states\n"
      << model.states() << "\n@nr_choices\n"
      << model.choices() << "\n@model\n";
  std::vector<ModelChoice> choices;
  std::string text;
  for (std::size_t state = 0; state < model.states(); ++state) {
    text = fmt::format("state {} ", state);
    append_rewards(text, 0.0, 0.0);
    for (const std::size_t label : model.labels_of(state)) {
      text += ' ' + model.label_names()[label];
    }
    text += '\n';
    if (state < chain.states()) {
      text += "//[";
      for (std::size_t f = 0; f < chain.vocabulary().features.size(); ++f) {
        const Feature& feature = chain.vocabulary().features[f];
        const std::uint8_t value = chain.features_of(state)[f];
        text += fmt::format("{}{}={}", f == 0 ? "" : "\t& ", feature.name,
                            feature.scale == Scale::bins ? fmt::format("{}", value) : feature.number_text(value));
      }
      text += "]\n";
    }
    model.choices_of(state, choices);
    for (const ModelChoice& choice : choices) {
      text += fmt::format("\taction {} ", choice.action);
      append_rewards(text, choice.gain, choice.cost);
      text += '\n';
      for (const ModelTarget& target : choice.targets) {
        text += fmt::format("\t\t{} : ", target.state);
        if (intervals) {
          text += '[';
          append_number(text, target.low);
          text += ", ";
          append_number(text, target.high);
          text += ']';
        } else {
          append_number(text, target.probability);
        }
        text += '\n';
      }
    }
    out << text;
  }
}

}  // namespace coppice
