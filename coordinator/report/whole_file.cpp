#include "coordinator/report/whole_file.hpp"

#include <cerrno>
#include <fcntl.h>
#include <fmt/format.h>
#include <fstream>
#include <system_error>
#include <unistd.h>

namespace coppice {
namespace {

// Hidden, in the same folder (a rename must not cross file systems), and named by the process so that two runs do not
// meet.
std::filesystem::path temporary_beside(const std::filesystem::path& path) {
  return path.parent_path() / fmt::format(".{}.{}.part", path.filename().string(), getpid());
}

std::string reason(int error) { return std::generic_category().message(error); }

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

}  // namespace

Result<void> produce_whole_file(const std::filesystem::path& path,
                                const std::function<Result<void>(const std::filesystem::path&)>& produce) {
  const std::filesystem::path temporary = temporary_beside(path);
  Result<void> done = produce(temporary);
  if (done) {
    done = flush_to_disk(temporary);
  }
  std::error_code error;
  if (done) {
    std::filesystem::rename(temporary, path, error);
    if (error) {
      done = failed(error.message());
    }
  }
  if (!done) {
    std::filesystem::remove(temporary, error);
    return in_context(fmt::format("cannot write {}", path.string()), std::move(done).error());
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
