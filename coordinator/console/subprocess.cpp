#include "coordinator/console/subprocess.hpp"

#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sstream>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <system_error>
#include <unistd.h>

#include "common/check.hpp"
#include "coordinator/console/printable.hpp"

namespace coppice {
namespace {

constexpr std::size_t kMostMessageBytes = 300;  // of what a program says when it fails

// A file without a name: what a child writes there needs nobody to read it meanwhile, and vanishes with us.
class MemoryFile {
 public:
  explicit MemoryFile(const char* name) : descriptor_(memfd_create(name, MFD_CLOEXEC)) {}
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() {
    if (descriptor_ >= 0) {
      close(descriptor_);
    }
  }
  int descriptor() const { return descriptor_; }

  bool fill(std::string_view content) const {
    while (!content.empty()) {
      const ssize_t written = write(descriptor_, content.data(), content.size());
      if (written < 0 && errno != EINTR) {
        return false;
      }
      content.remove_prefix(written > 0 ? static_cast<std::size_t>(written) : 0);
    }
    return lseek(descriptor_, 0, SEEK_SET) == 0;
  }

  std::string first_line() const {
    std::array<char, kMostMessageBytes> buffer{};
    const ssize_t size = pread(descriptor_, buffer.data(), buffer.size(), 0);
    const std::string_view text(buffer.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
    return std::string(text.substr(0, text.find('\n')));
  }

 private:
  int descriptor_;
};

}  // namespace

bool has_program(std::string_view name) {
  const char* path = getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const std::filesystem::path program = std::filesystem::path(folder.empty() ? "." : folder) / name;
    std::error_code error;
    if (std::filesystem::is_regular_file(program, error) && access(program.c_str(), X_OK) == 0) {
      return true;
    }
  }
  return false;
}

Result<void> run_program(std::vector<std::string> arguments, std::string_view input) {
  COPPICE_CHECK(!arguments.empty());
  const std::string name = arguments.front();
  const MemoryFile source("coppice-program-input");
  const MemoryFile messages("coppice-program-messages");
  if (source.descriptor() < 0 || messages.descriptor() < 0 || !source.fill(input)) {
    return failed(fmt::format("cannot hand the drawing to {}: {}", name, std::strerror(errno)));
  }
  std::vector<char*> argv;
  argv.reserve(arguments.size() + 1);
  for (std::string& argument : arguments) {
    argv.push_back(argument.data());
  }
  argv.push_back(nullptr);

  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, source.descriptor(), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&files, messages.descriptor(), STDERR_FILENO);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  // The signals that stop us are blocked here (stop.hpp) and would stay blocked there.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  pid_t child = 0;
  const int error = posix_spawnp(&child, name.c_str(), &files, &attributes, argv.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&attributes);
  if (error != 0) {
    return failed(fmt::format("cannot start '{}': {}", name, std::strerror(error)));
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    const std::string how = WIFEXITED(status) ? fmt::format("exit code {}", WEXITSTATUS(status))
                                              : fmt::format("killed by signal {}", WTERMSIG(status));
    return failed(fmt::format("'{}' failed ({}): {}", name, how, printable(messages.first_line())));
  }
  return {};
}

}  // namespace coppice
