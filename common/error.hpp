// How a failure that is not a bug travels: as a value. Anything that comes from outside (a file, a flag, bytes,
// a worker) and is wrong becomes an Error whose message names the place and what was expected. Bugs use
// COPPICE_CHECK instead (common/check.hpp). What a program's exit code makes of it is in common/exit_code.hpp.
#pragma once

#include <cstdint>
#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace coppice {

enum class ErrorKind : std::uint8_t {
  bad_input,    // the user's file, flag or text is wrong
  wrong_use,    // what was asked for does not exist
  failed,       // the environment failed (disk, network, process)
  interrupted,  // the user asked to stop; what was kept is valid
  no_worker,    // nobody came to evaluate within the limit; what was kept is valid
  damaged,      // a study that was whole once
  revoked,  // a worker was found to answer wrongly after some of its answers had counted: what rests on them is void
};

struct Error {
  ErrorKind kind = ErrorKind::failed;
  std::string message;  // one line, no trailing full stop needed, names file, line, field or flag
};

template <typename T>
using Result = tl::expected<T, Error>;

inline tl::unexpected<Error> bad_input(std::string message) {
  return tl::unexpected<Error>(Error{ErrorKind::bad_input, std::move(message)});
}

inline tl::unexpected<Error> failed(std::string message) {
  return tl::unexpected<Error>(Error{ErrorKind::failed, std::move(message)});
}

// `go_on` or a stop flag said to stop.
inline tl::unexpected<Error> interrupted() {
  return tl::unexpected<Error>(Error{ErrorKind::interrupted, "interrupted"});
}

// The same error with the place prepended: "room.txt: line 3: ...".
inline tl::unexpected<Error> in_context(const std::string& place, Error error) {
  error.message = place + ": " + error.message;
  return tl::unexpected<Error>(std::move(error));
}

}  // namespace coppice
