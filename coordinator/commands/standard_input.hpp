// Standard input that ends when the user wishes to stop: a read that waits for a pipe would otherwise wait on.
#pragma once

#include <array>
#include <streambuf>

#include "common/stop.hpp"

namespace coppice {

// One reader, one thread.
class StandardInput : public std::streambuf {
 public:
  // REQUIRES: `stop` outlives this. Throws std::system_error.
  explicit StandardInput(const StopFlag& stop);
  StandardInput(const StandardInput&) = delete;
  StandardInput& operator=(const StandardInput&) = delete;
  ~StandardInput() override;

 protected:
  int_type underflow() override;

 private:
  int woken_;  // eventfd, readable once the flag is raised
  StopFlag::Wake wake_;
  std::array<char, 65536> buffer_{};
};

}  // namespace coppice
