#include <CLI/CLI.hpp>
#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/version.hpp"
#include "coordinator/commands/commands.hpp"

namespace coppice {
namespace {

// A flag as a shell needs to know it.
struct Flag {
  std::vector<std::string> names;  // with their dashes
  std::string help;
  bool takes_value = false;
  std::vector<std::string> choices;  // of the value; empty: anything
};

struct Command {
  std::string name;
  std::string help;
  std::vector<Flag> flags;
  std::vector<std::string> words;  // that its argument may be; empty: a file
};

// CLI11 says which values there are only in words: "TEXT:{debug,info}".
std::vector<std::string> choices_of(std::string_view type) {
  std::vector<std::string> choices;
  const std::size_t open = type.find('{');
  const std::size_t close = type.find('}', open);
  if (open == std::string_view::npos || close == std::string_view::npos) {
    return choices;
  }
  std::string_view list = type.substr(open + 1, close - open - 1);
  // Ends with the list: every turn takes one word of it.
  while (!list.empty()) {
    const std::size_t comma = std::min(list.find(','), list.size());
    choices.emplace_back(list.substr(0, comma));
    list.remove_prefix(std::min(comma + 1, list.size()));
  }
  return choices;
}

std::vector<Flag> flags_of(const CLI::App& app) {
  std::vector<Flag> flags;
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_positional()) {
      continue;
    }
    Flag flag;
    for (const std::string& name : option->get_snames()) {
      flag.names.push_back("-" + name);
    }
    for (const std::string& name : option->get_lnames()) {
      flag.names.push_back("--" + name);
    }
    flag.help = option->get_description();
    flag.takes_value = option->get_type_size() != 0;
    flag.choices = choices_of(option->get_type_name());
    flags.push_back(std::move(flag));
  }
  return flags;
}

std::vector<Command> commands_of(const CLI::App& app) {
  std::vector<Command> commands;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    commands.push_back({command->get_name(), command->get_description(), flags_of(*command), {}});
    for (const CLI::Option* option : command->get_options()) {
      if (option->get_positional() && commands.back().words.empty()) {
        commands.back().words = choices_of(option->get_type_name());
      }
    }
  }
  std::vector<std::string> names;
  names.reserve(commands.size());
  for (const Command& command : commands) {
    names.push_back(command.name);
  }
  for (Command& command : commands) {
    if (command.name == "help") {
      command.words = names;
    }
  }
  return commands;
}

// In single quotes, in which no shell reads anything but the quote.
std::string shell_quoted(std::string_view text) {
  std::string result = "'";
  for (const char c : text) {
    result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  }
  return result + "'";
}

std::string bash_words(const std::vector<Flag>& flags) {
  std::string words;
  for (const Flag& flag : flags) {
    words += fmt::format("{}{}", words.empty() ? "" : " ", fmt::join(flag.names, " "));
  }
  return words;
}

// "--log-level) words='debug info';;", and for flags whose value may be anything: file names.
std::string bash_values(const std::vector<Flag>& flags, std::string_view indent) {
  std::string text;
  for (const Flag& flag : flags) {
    if (flag.takes_value) {
      text += fmt::format(
          "{}{}) {} ;;\n", indent, fmt::join(flag.names, "|"),
          flag.choices.empty() ? "files=1" : "words=" + shell_quoted(fmt::format("{}", fmt::join(flag.choices, " "))));
    }
  }
  return text;
}

std::string for_bash(const std::vector<Command>& commands, const std::vector<Flag>& global) {
  std::string names;
  for (const Command& command : commands) {
    names += command.name + " ";
  }
  std::string with_value;  // a pattern: their next word is no command
  for (const Flag& flag : global) {
    if (flag.takes_value) {
      with_value += fmt::format("{}{}", with_value.empty() ? "" : "|", fmt::join(flag.names, "|"));
    }
  }
  std::string text = fmt::format(
      "# Completion of coppice {} for bash: source it, or: eval \"$(coppice completion bash)\"\n"
      "_coppice() {{\n"
      "  local current=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD - 1]}} command= words= files= i\n"
      "  for ((i = 1; i < COMP_CWORD; ++i)); do\n"
      "    case ${{COMP_WORDS[i]}} in\n"
      "      {}) ((++i)) ;;\n"
      "      -*) ;;\n"
      "      *) command=${{COMP_WORDS[i]}}; break ;;\n"
      "    esac\n"
      "  done\n"
      "  case $command in\n"
      "    '')\n"
      "      words={}\n"
      "      case $previous in\n{}        *) ;;\n      esac ;;\n",
      kVersion, with_value, shell_quoted(names + bash_words(global)), bash_values(global, "        "));
  for (const Command& command : commands) {
    // A word that begins with no dash is the argument: one of its words, else a file.
    const std::string words =
        bash_words(command.flags) + (command.words.empty() ? "" : fmt::format(" {}", fmt::join(command.words, " ")));
    text += fmt::format("    {})\n      words={}\n      case $previous in\n{}        *) {} ;;\n      esac ;;\n",
                        command.name, shell_quoted(words), bash_values(command.flags, "        "),
                        command.words.empty() ? "[[ $current == -* ]] || files=1" : "");
  }
  return text +
         "  esac\n"
         "  if [[ $files ]]; then\n"
         "    mapfile -t COMPREPLY < <(compgen -f -- \"$current\")\n"
         "  else\n"
         "    mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$current\")\n"
         "  fi\n"
         "}\n"
         "complete -o filenames -F _coppice coppice\n";
}

// What _arguments would read as part of a specification.
std::string zsh_text(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') {
      result += '\\';
    }
    result += c;
  }
  return result;
}

std::string zsh_arguments(const std::vector<Flag>& flags, std::string_view indent) {
  std::string text;
  for (const Flag& flag : flags) {
    for (const std::string& name : flag.names) {
      std::string spec = fmt::format("{}[{}]", name, zsh_text(flag.help));
      if (flag.takes_value) {
        spec += flag.choices.empty() ? ":value:_files" : fmt::format(":value:({})", fmt::join(flag.choices, " "));
      }
      text += fmt::format("{}{} \\\n", indent, shell_quoted("*" + spec));
    }
  }
  return text;
}

std::string for_zsh(const std::vector<Command>& commands, const std::vector<Flag>& global) {
  std::string text = fmt::format(
      "#compdef coppice\n# Completion of coppice {} for zsh: a file named _coppice in a folder of $fpath\n"
      "_coppice() {{\n  local state\n  local -a commands\n  commands=(\n",
      kVersion);
  for (const Command& command : commands) {
    text += fmt::format("    {}\n", shell_quoted(command.name + ":" + zsh_text(command.help)));
  }
  text +=
      fmt::format("  )\n  _arguments -C \\\n{}    '1: :->command' '*:: :->arguments'\n", zsh_arguments(global, "    "));
  text +=
      "  case $state in\n    command) _describe command commands ;;\n    arguments)\n      case $words[1] in\n"
      "        help) _describe command commands ;;\n";
  for (const Command& command : commands) {
    if (command.name != "help") {
      text += fmt::format("        {})\n          _arguments \\\n{}            '*:file:_files' ;;\n", command.name,
                          zsh_arguments(command.flags, "            "));
    }
  }
  return text + "      esac ;;\n  esac\n}\n_coppice \"$@\"\n";
}

std::string fish_flags(const std::vector<Flag>& flags, const std::string& where) {
  std::string text;
  for (const Flag& flag : flags) {
    text += "complete -c coppice -n " + shell_quoted(where);
    for (const std::string& name : flag.names) {
      text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
    }
    if (flag.takes_value) {
      text += flag.choices.empty()
                  ? " -r"
                  : fmt::format(" -x -a {}", shell_quoted(fmt::format("{}", fmt::join(flag.choices, " "))));
    }
    text += " -d " + shell_quoted(flag.help) + "\n";
  }
  return text;
}

std::string for_fish(const std::vector<Command>& commands, const std::vector<Flag>& global) {
  std::string text = fmt::format("# Completion of coppice {} for fish: coppice completion fish | source\n", kVersion);
  text += fish_flags(global, "__fish_use_subcommand");
  for (const Command& command : commands) {
    text += fmt::format("complete -c coppice -n __fish_use_subcommand -f -a {} -d {}\n", command.name,
                        shell_quoted(command.help));
    text += fmt::format("complete -c coppice -n '__fish_seen_subcommand_from help' -f -a {}\n", command.name);
    text += fish_flags(command.flags, "__fish_seen_subcommand_from " + command.name);
  }
  return text;
}

}  // namespace

void add_completion(CLI::App& app, Invocation& invocation) {
  const auto shell = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand("completion", "Print what makes a shell complete commands and flags");
  command->add_option("SHELL", *shell, "bash, zsh or fish")->required()->check(CLI::IsMember({"bash", "zsh", "fish"}));
  command->footer(
      "Examples:\n"
      "  eval \"$(coppice completion bash)\"                        # this shell; in ~/.bashrc: every shell\n"
      "  coppice completion zsh > ~/.zfunc/_coppice               # a folder of $fpath\n"
      "  coppice completion fish > ~/.config/fish/completions/coppice.fish");
  command->callback([&app, &invocation, shell] {
    invocation.chosen = [&app, shell]() -> Result<void> {
      const std::vector<Command> commands = commands_of(app);
      const std::vector<Flag> global = flags_of(app);
      fmt::print("{}", *shell == "bash"  ? for_bash(commands, global)
                       : *shell == "zsh" ? for_zsh(commands, global)
                                         : for_fish(commands, global));
      return {};
    };
  });
}

}  // namespace coppice
