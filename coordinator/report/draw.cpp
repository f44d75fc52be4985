#include "coordinator/report/draw.hpp"

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <iterator>
#include <signal.h>
#include <spawn.h>
#include <sstream>
#include <stdlib.h>
#include <string_view>
#include <sys/mman.h>
#include <sys/wait.h>
#include <system_error>
#include <unistd.h>
#include <vector>

#include "common/tree/text.hpp"
#include "coordinator/report/printable.hpp"
#include "coordinator/report/whole_file.hpp"

namespace coppice {
namespace {

constexpr std::size_t kMostMessageBytes = 300;  // of what `dot` says when it fails

// A DOT string: only the quote and the backslash are special inside double quotes.
std::string dot_string(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      result += '\\';
    }
    result += c;
  }
  return result + "\"";
}

std::string label_of(const Node& node, const Vocabulary& vocabulary) {
  switch (node.kind) {
    case NodeKind::sequence:
      return "\xE2\x86\x92";  // U+2192, rightwards arrow
    case NodeKind::selector:
      return "?";
    case NodeKind::condition:
    case NodeKind::action:
      break;
  }
  return to_text(node, vocabulary);
}

std::string_view shape_of(const Node& node) {
  switch (node.kind) {
    case NodeKind::condition:
      return "ellipse";
    case NodeKind::action:
      return "box";
    case NodeKind::sequence:
    case NodeKind::selector:
      break;
  }
  return "square";
}

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

tl::unexpected<Error> no_dot() {
  return failed("the program 'dot' of Graphviz is not on PATH: install graphviz, or write a .dot file");
}

Result<void> run_dot(const std::string& source, std::string_view format, const std::filesystem::path& path) {
  const MemoryFile input("coppice-dot-input");
  const MemoryFile messages("coppice-dot-messages");
  if (input.descriptor() < 0 || messages.descriptor() < 0 || !input.fill(source)) {
    return failed(fmt::format("cannot hand the drawing to dot: {}", std::strerror(errno)));
  }
  std::vector<std::string> arguments = {"dot", fmt::format("-T{}", format), "-o", path.string()};
  std::vector<char*> argv;
  argv.reserve(arguments.size() + 1);
  for (std::string& argument : arguments) {
    argv.push_back(argument.data());
  }
  argv.push_back(nullptr);

  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, input.descriptor(), STDIN_FILENO);
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
  const int error = posix_spawnp(&child, "dot", &files, &attributes, argv.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&attributes);
  if (error == ENOENT) {
    return no_dot();
  }
  if (error != 0) {
    return failed(fmt::format("cannot start 'dot': {}", std::strerror(error)));
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    const std::string how = WIFEXITED(status) ? fmt::format("exit code {}", WEXITSTATUS(status))
                                              : fmt::format("killed by signal {}", WTERMSIG(status));
    return failed(fmt::format("'dot' failed ({}): {}", how, printable(messages.first_line())));
  }
  return {};
}

}  // namespace

std::string to_dot(const Tree& tree, const Vocabulary& vocabulary) {
  std::string text =
      "digraph tree {\n"
      "  graph [ordering=out];\n"
      "  node [fontname=\"Helvetica\", fontsize=12];\n"
      "  edge [arrowsize=0.6];\n";
  struct Open {
    std::size_t node;
    std::size_t end;
  };
  std::vector<Open> open;  // composites around the current node, outermost first
  for (std::size_t i = 0; i < tree.size(); ++i) {
    const Node& node = tree[i];
    while (!open.empty() && open.back().end <= i) {
      open.pop_back();
    }
    fmt::format_to(std::back_inserter(text), "  n{} [shape={}, label={}];\n", i, shape_of(node),
                   dot_string(label_of(node, vocabulary)));
    if (!open.empty()) {
      fmt::format_to(std::back_inserter(text), "  n{} -> n{};\n", open.back().node, i);
    }
    if (node.is_composite()) {
      open.push_back({i, i + node.extent});
    }
  }
  return text + "}\n";
}

Result<DrawingFormat> drawing_format(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  if (extension == ".dot") {
    return DrawingFormat::dot;
  }
  if (extension == ".svg") {
    return DrawingFormat::svg;
  }
  if (extension == ".png") {
    return DrawingFormat::png;
  }
  return bad_input(
      fmt::format("{}: drawing has extension '{}': expected .svg, .png or .dot", path.string(), extension));
}

Result<void> check_dot() {
  const char* path = getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const std::filesystem::path program = std::filesystem::path(folder.empty() ? "." : folder) / "dot";
    std::error_code error;
    if (std::filesystem::is_regular_file(program, error) && access(program.c_str(), X_OK) == 0) {
      return {};
    }
  }
  return no_dot();
}

Result<void> write_drawing(const Tree& tree, const Vocabulary& vocabulary, const std::filesystem::path& path) {
  const Result<DrawingFormat> format = drawing_format(path);
  if (!format) {
    return tl::unexpected(format.error());
  }
  const std::string source = to_dot(tree, vocabulary);
  if (*format == DrawingFormat::dot) {
    return write_whole_file(path, source);
  }
  const std::string_view program_format = *format == DrawingFormat::svg ? "svg" : "png";
  return produce_whole_file(
      path, [&](const std::filesystem::path& temporary) { return run_dot(source, program_format, temporary); });
}

}  // namespace coppice
