#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "common/evolution/config.hpp"
#include "common/evolution/config_keys.hpp"
#include "common/exit_code.hpp"
#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/did_you_mean.hpp"

namespace coppice {
namespace {

struct Topic {
  std::string_view name;
  std::string_view about;
  std::string_view text;  // empty: made when it is asked for
};

constexpr std::array<Topic, 7> kTopics = {{
    {"trees", "the text form of a tree",
     R"(A tree is one line of text:

  (selector (sequence s3=0 turn_left) (sequence s1=3 s3=1 turn_left) move)

  (sequence CHILD ...)   its children in turn, until one fails; succeeds if none does
  (selector CHILD ...)   its children in turn, until one succeeds; fails if none does
  s3=0, x<=4             a condition: succeeds if the feature has that value, or at most that value
  turn_left              an action: is chosen, and succeeds

The last action chosen before the root ends is what the tree does. Where none was chosen, the agent holds its state. Names of
features and actions are those of the study (coppice info STUDY). --tree takes such a line or a file that holds one;
lines that begin with # are remarks.
)"},
    {"rules", "what coppice verify proves",
     R"(A rule is one line:

  never move when s3=0
  always turn_left or turn_right when s3=0 and s1!=3
  never none                                (it always chooses an action)

  rule      = (never | always) ACTION {or ACTION} [when CONDITION]
  CONDITION = TEST {and TEST} {or TEST {and TEST}}
  TEST      = FEATURE (= | != | <= | < | >= | >) VALUE

A rule is proved for every observation that the features' values allow, or broken by one that is shown.
)"},
    {"pick", "which tree of a front is the answer",
     R"(--pick of coppice front, and the key front.pick:

  best return with nodes<=20 and coverage>=0.8 and collisions=0
  best return with collisions=0 else best agreement
  best fitness

  rule   = CHOICE {else CHOICE}             the first that some tree fits
  CHOICE = best MEASURE [with MEASURE (<= | >= | =) NUMBER {and ...}]

A measure is one that the run evaluated, nodes, or fitness; shares are from 0 to 1. Of costs (collisions, regret, unknown, nodes)
the best is the smallest.
)"},
    {"keys", "every key of a configuration, with its default", ""},
    {"files", "what is written where",
     R"(  STUDY.coppice                    one SQLite file: the problem, its chain, every run with its configuration, generations,
                                   checkpoint and trees. Nothing else is needed to go on, here or on another machine
  coppice-run-TIME/                what coppice run makes: study.coppice, table-iv.json, drawings. coppice-refine-TIME/ and
                                   coppice-thesis-TIME/ likewise; -o names another folder
  FOLDER of coppice sweep          settings.csv, runs.csv, runs.jsonl (what --resume goes on from), sweep.svg

A file that exists is never overwritten unless --force says so. Files appear whole or not at all.
)"},
    {"exit-codes", "how a command ends, for a scheduler", ""},
    {"environment", "variables that are read",
     R"(  PATH             where dot, gnuplot and coppice-worker are looked for
  CYCLONEDDS_URI   a DDS configuration of your own instead of Coppice's (idl/README.md says what it must hold)
  TMPDIR           where short-lived files go
)"},
}};

std::string as_text(const ConfigValue& value) {
  return std::visit(
      [](const auto& held) -> std::string {
        using Held = std::decay_t<decltype(held)>;
        if constexpr (std::is_same_v<Held, std::string>) {
          return fmt::format("\"{}\"", held);
        } else if constexpr (std::is_same_v<Held, OtherValue>) {
          return held.description;
        } else {
          return fmt::format("{}", held);
        }
      },
      value);
}

std::string keys_text() {
  EvolveConfig config;
  const std::vector<ConfigKey> keys = keys_of(config);
  std::size_t width = 0;
  for (const ConfigKey& key : keys) {
    width = std::max(width, key.full_name().size());
  }
  std::string text =
      "Each can stand in a file (--config FILE.toml, sections in brackets) and on the command line (--set KEY=VALUE). "
      "Shown\n"
      "is what holds where neither a recipe nor a file nor --set says otherwise: the thesis, Table III.\n\n";
  for (const ConfigKey& key : keys) {
    text += fmt::format("  {:<{}} = {}", key.full_name(), width, as_text(value_of(key)));
    text += key.low < key.high ? fmt::format("   from {:.15g} to {:.15g}\n", key.low, key.high) : "\n";
    text += fmt::format("      {}\n", key.help);
  }
  return text + "\n[[fitness.rule]] (any_of, right, wrong), rules of the objective 'shaped', only in a file.\n";
}

std::string exit_topic() {
  return fmt::format(
      "coppice and coppice-worker end with\n\n{}\nWhat ended with 1, 4 or 5 may be started again, the others not "
      "before "
      "what the message names is mended. A second\nCtrl-C ends a command at once, with 130. A worker that SIGTERM ends "
      "gives back what it holds and ends with 0.\n",
      exit_codes_text());
}

std::string topics_text() {
  std::string text = "Topics besides the commands:\n";
  for (const Topic& topic : kTopics) {
    text += fmt::format("  {:<27} {}\n", topic.name, topic.about);
  }
  return text;
}

Result<void> help_command(const CLI::App& app, const std::string& wanted) {
  if (wanted.empty()) {
    fmt::print("{}\n{}", app.help(), topics_text());
    return {};
  }
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_name() == wanted) {
      fmt::print("{}", command->help(app.get_name()));
      return {};
    }
    names.push_back(command->get_name());
  }
  for (const Topic& topic : kTopics) {
    if (topic.name == wanted) {
      fmt::print("{}", !topic.text.empty()      ? std::string(topic.text)
                       : wanted == "exit-codes" ? exit_topic()
                                                : keys_text());
      return {};
    }
    names.emplace_back(topic.name);
  }
  const std::vector<std::string> near = nearest(wanted, names);
  return tl::unexpected(Error{ErrorKind::wrong_use,
                              fmt::format("'{}' is no command and no topic{}", wanted,
                                          near.empty() ? std::string(" (see coppice help)")
                                                       : fmt::format(" (did you mean {}?)", fmt::join(near, " or ")))});
}

}  // namespace

void add_help(CLI::App& app, Invocation& invocation) {
  const auto wanted = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand("help", "Explain a command or a topic: coppice help keys");
  command->add_option("TOPIC", *wanted, "A command, or a topic (default: what there is)");
  command->footer(topics_text() + "Example:\n  coppice help rules");
  command->callback(
      [&app, &invocation, wanted] { invocation.chosen = [&app, wanted] { return help_command(app, *wanted); }; });
}

}  // namespace coppice
