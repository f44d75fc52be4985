#include "coordinator/commands/standard_input.hpp"

#include <cerrno>
#include <cstdint>
#include <poll.h>
#include <sys/eventfd.h>
#include <system_error>
#include <unistd.h>

namespace coppice {

StandardInput::StandardInput(const StopFlag& stop) : woken_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (woken_ < 0) {
    throw std::system_error(errno, std::generic_category(), "cannot wait for standard input");
  }
  wake_ = stop.on_raise([this] {
    const std::uint64_t one = 1;
    [[maybe_unused]] const ssize_t written = write(woken_, &one, sizeof one);
  });
}

StandardInput::~StandardInput() {
  wake_ = {};
  close(woken_);
}

StandardInput::int_type StandardInput::underflow() {
  // Every turn waits for an event; ends with data, the end of input, or the user's wish.
  while (true) {
    std::array<pollfd, 2> sources = {{{STDIN_FILENO, POLLIN, 0}, {woken_, POLLIN, 0}}};
    if (poll(sources.data(), sources.size(), -1) < 0 && errno != EINTR) {
      return traits_type::eof();
    }
    if ((sources[1].revents & POLLIN) != 0) {
      return traits_type::eof();
    }
    const ssize_t size = read(STDIN_FILENO, buffer_.data(), buffer_.size());
    if (size > 0) {
      setg(buffer_.data(), buffer_.data(), buffer_.data() + size);
      return traits_type::to_int_type(buffer_.front());
    }
    if (size == 0 || (errno != EINTR && errno != EAGAIN)) {
      return traits_type::eof();
    }
  }
}

}  // namespace coppice
