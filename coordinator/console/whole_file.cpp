#include "coordinator/console/whole_file.hpp"

#include <cerrno>
#include <fcntl.h>
#include <fmt/format.h>
#include <fstream>
#include <system_error>
#include <unistd.h>

namespace coppice {
namespace {

std::string reason(int error) { return std::generic_category().message(error); }

constexpr int kMostLinks = 40;  // as Linux follows

// The file that symbolic links lead to, whether it exists or not.
Result<std::filesystem::path> without_links(std::filesystem::path path) {
  std::error_code error;
  for (int i = 0; i < kMostLinks; ++i) {
    if (!std::filesystem::is_symlink(std::filesystem::symlink_status(path, error))) {
      return path;
    }
    path = path.parent_path() / std::filesystem::read_symlink(path, error);  // an absolute one replaces the folder
    if (error) {
      return failed(error.message());
    }
  }
  return failed(reason(ELOOP));
}

// Hidden, in the same folder (a rename must not cross file systems), and named by the process so that two runs do not
// meet.
std::filesystem::path temporary_beside(const std::filesystem::path& path) {
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  // Absolute: the programs that draw would take a name that begins with '-' for a flag.
  return std::filesystem::absolute(folder) / fmt::format(".{}.{}.part", path.filename().string(), getpid());
}

// A rename that reaches the disk before its content would leave an empty file after a power cut.
Result<void> flush_to_disk(const std::filesystem::path& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) {
    return failed(reason(errno));
  }
  const int error = fsync(file) == 0 ? 0 : errno;
  close(file);
  if (error != 0 && error != EINVAL && error != EROFS) {
    return failed(reason(error));
  }
  return {};
}

using Produce = std::function<Result<void>(const std::filesystem::path&)>;

// `before`: what is under that name now.
Result<void> replace(const std::filesystem::path& path, const std::filesystem::file_status& before,
                     const Produce& produce) {
  const std::filesystem::path temporary = temporary_beside(path);
  Result<void> done = produce(temporary);
  if (done) {
    done = flush_to_disk(temporary);
  }
  std::error_code error;
  if (done && std::filesystem::exists(before)) {
    std::filesystem::permissions(temporary, before.permissions(), error);
  }
  if (done && !error) {
    std::filesystem::rename(temporary, path, error);
  }
  if (done && error) {
    done = failed(error.message());
  }
  if (!done) {
    std::filesystem::remove(temporary, error);
  }
  return done;
}

Result<void> write_there(const std::filesystem::path& path, const Produce& produce) {
  std::error_code error;
  const std::filesystem::file_status before = std::filesystem::status(path, error);
  if (std::filesystem::is_directory(before)) {
    return failed(reason(EISDIR));
  }
  if (std::filesystem::exists(before) && !std::filesystem::is_regular_file(before)) {
    return produce(path);
  }
  const Result<std::filesystem::path> target = without_links(path);
  if (!target) {
    return tl::unexpected(target.error());
  }
  // Said here, because another program that is to write there may fail without a reason.
  const std::filesystem::path folder = target->has_parent_path() ? target->parent_path() : ".";
  if (!std::filesystem::is_directory(folder, error)) {
    return failed(reason(std::filesystem::exists(folder, error) ? ENOTDIR : ENOENT));
  }
  return replace(*target, before, produce);
}

}  // namespace

Result<void> produce_whole_file(const std::filesystem::path& path, const Produce& produce) {
  Result<void> done = write_there(path, produce);
  return done ? done : in_context(fmt::format("cannot write {}", path.string()), std::move(done).error());
}

Result<void> check_other_file(const char* flag, const std::filesystem::path& output,
                              const std::filesystem::path& input) {
  std::error_code error;  // a file that does not exist is another one
  if (std::filesystem::equivalent(output, input, error)) {
    return bad_input(fmt::format("{} {}: is the study itself: expected another file", flag, output.string()));
  }
  return {};
}

Result<void> write_whole_file(const std::filesystem::path& path, const std::function<void(std::ostream&)>& fill) {
  return produce_whole_file(path, [&](const std::filesystem::path& temporary) -> Result<void> {
    errno = 0;
    std::ofstream out(temporary, std::ios::binary | std::ios::trunc);
    if (!out) {
      return failed(reason(errno));
    }
    fill(out);
    out.close();
    if (!out) {
      return failed(errno != 0 ? reason(errno) : "the disk refused the content");
    }
    return {};
  });
}

Result<void> write_whole_file(const std::filesystem::path& path, std::string_view content) {
  return write_whole_file(
      path, [&](std::ostream& out) { out.write(content.data(), static_cast<std::streamsize>(content.size())); });
}

}  // namespace coppice
