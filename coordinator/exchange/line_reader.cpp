#include "coordinator/exchange/line_reader.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fmt/format.h>
#include <sys/stat.h>

namespace coppice {
namespace {

constexpr std::size_t kFirstBuffer = std::size_t{1} << 18U;  // bytes

Result<std::uint64_t> size_of_file(const std::string& path, std::FILE* file) {
  struct stat status {};
  if (file == nullptr || ::fstat(fileno(file), &status) != 0) {
    return bad_input(fmt::format("{}: cannot be opened: {}", path, std::strerror(errno)));
  }
  if (S_ISDIR(status.st_mode)) {
    return bad_input(fmt::format("{}: is a folder: expected a file", path));
  }
  return static_cast<std::uint64_t>(status.st_size);
}

}  // namespace

LineReader::LineReader(std::string path, std::FILE* file, std::uint64_t size)
    : path_(std::move(path)), file_(file), size_(size), buffer_(kFirstBuffer) {}

Result<LineReader> LineReader::open(const std::string& path) {
  std::FILE* file = std::fopen(path.c_str(), "rbe");
  const auto size = size_of_file(path, file);
  if (!size) {
    if (file != nullptr) {
      static_cast<void>(std::fclose(file));
    }
    return tl::unexpected(size.error());
  }
  return LineReader(path, file, *size);
}

bool LineReader::fill() {
  std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
  end_ -= begin_;
  begin_ = 0;
  if (end_ * 2 > buffer_.size()) {  // a long line: at most kMaxLine, which next() sees to
    buffer_.resize(buffer_.size() * 2);
  }
  const std::size_t read = std::fread(buffer_.data() + end_, 1, buffer_.size() - end_, file_.get());
  end_ += read;
  bytes_read_ += read;
  if (read == 0 && std::ferror(file_.get()) != 0) {
    failed_ = true;
    error_ = fmt::format("{}: cannot be read: {}", path_, std::strerror(errno));
  }
  at_end_ = read == 0;
  return read > 0;
}

bool LineReader::next(std::string_view& line) {
  while (!failed_) {  // ends: every turn gives a line, reads on, or is the last
    const char* first = buffer_.data() + begin_;
    const auto* found = static_cast<const char*>(std::memchr(first, '\n', end_ - begin_));
    std::size_t length = found != nullptr ? static_cast<std::size_t>(found - first) : end_ - begin_;
    if (length > kMaxLine) {
      failed_ = true;
      error_ = fmt::format("{}: line {}: more than {} bytes: expected a text file with shorter lines", path_,
                           line_number_ + 1, kMaxLine);
      return false;
    }
    if (found == nullptr && !at_end_) {
      fill();
      continue;
    }
    if (found == nullptr && length == 0) {
      return false;
    }
    begin_ += length + (found != nullptr ? 1 : 0);
    length -= length > 0 && first[length - 1] == '\r' ? 1 : 0;
    line = std::string_view(first, length);
    ++line_number_;
    return true;
  }
  return false;
}

std::string LineReader::where() const { return fmt::format("{}: line {}", path_, line_number_); }

Result<std::string> first_bytes(const std::string& path, std::size_t most) {
  std::FILE* file = std::fopen(path.c_str(), "rbe");
  const auto size = size_of_file(path, file);
  std::string bytes;
  if (size) {
    bytes.resize(most);
    bytes.resize(std::fread(bytes.data(), 1, most, file));
  }
  if (file != nullptr) {
    static_cast<void>(std::fclose(file));
  }
  return size ? Result<std::string>(std::move(bytes)) : tl::unexpected(size.error());
}

}  // namespace coppice
