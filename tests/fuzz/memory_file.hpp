// Bytes under a path, for readers of files: in memory, gone with this object.
#pragma once

#include <string>
#include <string_view>
#include <sys/mman.h>
#include <unistd.h>

#include "common/check.hpp"

namespace coppice::fuzz {

class MemoryFile {
 public:
  explicit MemoryFile(std::string_view bytes) : descriptor_(::memfd_create("input", MFD_CLOEXEC)) {
    COPPICE_CHECK(descriptor_ >= 0);
    while (!bytes.empty()) {  // ends: every turn writes some
      const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
      COPPICE_CHECK(written > 0);
      bytes.remove_prefix(static_cast<std::size_t>(written));
    }
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() { ::close(descriptor_); }

  std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

 private:
  int descriptor_;
};

}  // namespace coppice::fuzz
