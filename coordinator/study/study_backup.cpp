#include "coordinator/study/study_backup.hpp"

#include <cerrno>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <system_error>
#include <unistd.h>

#include "coordinator/study/database.hpp"

namespace coppice {
namespace {

std::filesystem::path beside(const std::filesystem::path& path) {
  return path.parent_path() / fmt::format(".{}.{}.part", path.filename().string(), getpid());
}

Result<void> to_disk(const std::filesystem::path& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const int error = file < 0 || fsync(file) != 0 ? errno : 0;
  if (file >= 0) {
    close(file);
  }
  return error == 0 ? Result<void>() : failed(std::generic_category().message(error));
}

}  // namespace

// VACUUM INTO (sqlite.org/lang_vacuum.html) reads in one transaction, which sees one moment whatever others write.
Result<void> back_up_study(const std::string& from, const std::string& to) {
  const std::filesystem::path part = beside(to);
  std::error_code error;
  std::filesystem::remove(part, error);  // of a process of the same number that was killed
  Result<void> done = guarded(from, [&]() -> Result<void> {
    auto database = open_database(from, false);
    if (!database) {
      return tl::unexpected(database.error());
    }
    SQLite::Statement copy(*database, "VACUUM INTO ?");
    copy.bind(1, part.string());
    copy.executeStep();
    return {};
  });
  if (done) {
    done = to_disk(part);
  }
  if (done) {
    std::filesystem::rename(part, to, error);
    done = error ? failed(fmt::format("cannot write {}: {}", to, error.message())) : Result<void>();
  }
  if (!done) {
    std::filesystem::remove(part, error);
  }
  return done;
}

}  // namespace coppice
