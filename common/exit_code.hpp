// How both programs end, for whoever starts them: the one table. A scheduler may start again what ended with
// environment, interrupted or no_worker; the others end alike until somebody mends what the message names.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/error.hpp"

namespace coppice {

enum class ExitCode : std::uint8_t {
  finished = 0,
  environment = 1,
  wrong_use = 2,
  bad_input = 3,
  interrupted = 4,
  no_worker = 5,
  study_damaged = 6,
};

struct ExitCodeRow {
  ExitCode code;
  std::string_view name;
  std::string_view meaning;
};
inline constexpr std::array<ExitCodeRow, 7> kExitCodes = {{
    {ExitCode::finished, "finished", "what was asked for is done"},
    {ExitCode::environment, "environment", "disk, network or another process failed, or what was asked does not hold"},
    {ExitCode::wrong_use, "wrong use", "the command line: a flag, or the value of one"},
    {ExitCode::bad_input, "bad input", "a file, study or tree that is not what it should be"},
    {ExitCode::interrupted, "interrupted", "by Ctrl-C or SIGTERM; the best so far is kept, --resume goes on"},
    {ExitCode::no_worker, "no worker", "none came within --wait; what was evaluated is kept, --resume goes on"},
    {ExitCode::study_damaged, "study damaged", "coppice check STUDY says what can be saved"},
}};
// Besides: 130, interrupted a second time before the end; 128 + N in a shell, killed by signal N.

constexpr int to_int(ExitCode code) { return static_cast<int>(code); }

// An error about the command line begins with the flag that it is about; that is how it differs from one about a file.
inline ExitCode exit_code_of(const Error& error) {
  switch (error.kind) {
    case ErrorKind::bad_input:
      return error.message.rfind('-', 0) == 0 ? ExitCode::wrong_use : ExitCode::bad_input;
    case ErrorKind::wrong_use:
      return ExitCode::wrong_use;
    case ErrorKind::interrupted:
      return ExitCode::interrupted;
    case ErrorKind::no_worker:
      return ExitCode::no_worker;
    case ErrorKind::damaged:
      return ExitCode::study_damaged;
    case ErrorKind::failed:
    case ErrorKind::revoked:
      break;
  }
  return ExitCode::environment;
}

// The table as lines of text, for help.
inline std::string exit_codes_text() {
  constexpr std::size_t kNameWidth = 15;
  std::string text;
  for (const ExitCodeRow& row : kExitCodes) {
    text += "  " + std::to_string(to_int(row.code)) + "  " + std::string(row.name) +
            std::string(kNameWidth - row.name.size(), ' ') + std::string(row.meaning) + "\n";
  }
  return text;
}

}  // namespace coppice
