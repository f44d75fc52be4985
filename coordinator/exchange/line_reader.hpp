// A text file, line by line, of any length, in constant memory. Owns the open file. One thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/error.hpp"

namespace coppice {

inline constexpr std::size_t kMaxLine = std::size_t{1} << 20U;  // bytes

class LineReader {
 public:
  // Error (bad_input): cannot be opened, or is a folder.
  static Result<LineReader> open(const std::string& path);

  // The next line without its end (LF or CR LF); valid until the next call. False: the end, or failed().
  bool next(std::string_view& line);
  // A line longer than kMaxLine, or the file cannot be read: naming file and line.
  bool failed() const { return failed_; }
  Error error() const { return {ErrorKind::bad_input, error_}; }

  // Of the line that next() gave last, from 1.
  std::size_t line_number() const { return line_number_; }
  // "model.drn: line 17", for messages.
  std::string where() const;
  std::uint64_t bytes_read() const { return bytes_read_; }
  std::uint64_t size() const { return size_; }

 private:
  struct Close {
    void operator()(std::FILE* file) const { static_cast<void>(std::fclose(file)); }
  };

  LineReader(std::string path, std::FILE* file, std::uint64_t size);
  bool fill();

  std::string path_;
  std::unique_ptr<std::FILE, Close> file_;
  std::uint64_t size_ = 0;
  std::uint64_t bytes_read_ = 0;
  std::vector<char> buffer_;
  std::size_t begin_ = 0;  // of what is not yet given, in buffer_
  std::size_t end_ = 0;
  bool at_end_ = false;
  bool failed_ = false;
  std::string error_;
  std::size_t line_number_ = 0;
};

// The first bytes of a file, to tell its format. Errors as LineReader::open().
Result<std::string> first_bytes(const std::string& path, std::size_t most);

}  // namespace coppice
