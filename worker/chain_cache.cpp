#include "worker/chain_cache.hpp"

#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>
#include <vector>

namespace coppice {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExtension = ".chain";
constexpr mode_t kMode = 0644;

std::string message_of(int error) { return std::generic_category().message(error); }

// The whole of it, or false with errno.
bool write_all(int file, std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file, bytes.data(), bytes.size());
    if (written < 0 && errno != EINTR) {
      return false;
    }
    bytes = bytes.subspan(static_cast<std::size_t>(std::max<ssize_t>(written, 0)));
  }
  return true;
}

bool read_all(int file, std::span<std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t read = ::read(file, bytes.data(), bytes.size());
    if (read == 0 || (read < 0 && errno != EINTR)) {
      return false;
    }
    bytes = bytes.subspan(static_cast<std::size_t>(std::max<ssize_t>(read, 0)));
  }
  return true;
}

}  // namespace

Result<ChainCache> ChainCache::open(fs::path folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!error && !fs::is_directory(folder, error)) {
    error = std::make_error_code(std::errc::not_a_directory);
  }
  if (!error && ::access(folder.c_str(), R_OK | W_OK | X_OK) != 0) {
    error = std::error_code(errno, std::generic_category());
  }
  if (error) {
    return bad_input(
        fmt::format("--cache: {}: {}: expected a folder that can be written", folder.string(), error.message()));
  }
  return ChainCache(std::move(folder));
}

ChainCache::ChainCache(ChainCache&& other) noexcept
    : folder_(std::move(other.folder_)),
      path_(std::move(other.path_)),
      file_(std::exchange(other.file_, -1)),
      writes_(std::exchange(other.writes_, false)),
      written_(other.written_),
      complained_(other.complained_) {}

ChainCache::~ChainCache() { close(); }

std::size_t ChainCache::resume(Assembly& assembly) {
  close();
  path_ = folder_ / (assembly.hash().hex() + kExtension);
  file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, kMode);
  struct stat status {};
  if (file_ < 0 || ::fstat(file_, &status) != 0) {
    complain("open", errno);
    return 0;
  }
  writes_ = ::flock(file_, LOCK_EX | LOCK_NB) == 0;
  const bool readable = read_blocks(assembly, static_cast<std::size_t>(std::max<off_t>(status.st_size, 0)));
  const std::size_t found = assembly.leading();
  written_ = found;
  if (writes_) {
    // A block that was cut short by the end of its writer, and whatever is behind the chain's last byte.
    const std::size_t whole = std::min<std::size_t>(written_ * assembly.block_bytes(), assembly.size());
    if (!readable || ::ftruncate(file_, static_cast<off_t>(whole)) != 0 || ::lseek(file_, 0, SEEK_END) < 0) {
      complain("read", errno);
    }
    ::futimens(file_, nullptr);  // used now; a clock that is wrong costs a transfer at worst
  }
  drop_oldest();  // also of chains that never came: whoever announces many must not fill the disk
  return found;
}

// False: the file could not be read as far as it should go.
bool ChainCache::read_blocks(Assembly& assembly, std::size_t length) const {
  const std::size_t size = assembly.size();
  const std::size_t block = assembly.block_bytes();
  length = std::min(length, size);
  std::vector<std::uint8_t> bytes;
  for (std::size_t begin = 0; begin < length; begin += block) {
    const std::size_t count = std::min(block, size - begin);
    if (begin + count > length) {
      break;  // cut short
    }
    bytes.resize(count);
    if (!read_all(file_, bytes) || !assembly.add(static_cast<std::uint32_t>(begin / block), bytes)) {
      return false;
    }
  }
  return true;
}

void ChainCache::keep(const Assembly& assembly) {
  while (writes_ && written_ < assembly.leading()) {
    if (!write_all(file_, assembly.block(written_))) {
      complain("write", errno);
      return;
    }
    ++written_;
  }
}

void ChainCache::done() { close(); }

void ChainCache::discard() {
  if (writes_) {
    std::error_code ignored;  // it is overwritten next time, then
    fs::remove(path_, ignored);
  }
  close();
}

void ChainCache::close() {
  if (file_ >= 0) {
    ::close(file_);
  }
  file_ = -1;
  writes_ = false;
  written_ = 0;
}

// The chain at hand is not kept; the next one may be.
void ChainCache::complain(const char* what, int error) {
  if (!std::exchange(complained_, true)) {
    spdlog::warn("cannot {} {}: {}; the chain is held in memory only", what, path_.string(), message_of(error));
  }
  close();
}

void ChainCache::drop_oldest() const {
  std::vector<std::pair<fs::file_time_type, fs::path>> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder_, error)) {
    if (entry.path().extension() == kExtension) {
      files.emplace_back(entry.last_write_time(error), entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  for (std::size_t i = 0; i + kMaxFiles < files.size(); ++i) {
    fs::remove(files[i].second, error);  // whoever has it open goes on with it
  }
}

}  // namespace coppice
