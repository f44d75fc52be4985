#include "tests/fuzz/last_input.hpp"

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <string_view>
#include <unistd.h>

// Defined where a sanitizer is linked.
extern "C" void __sanitizer_set_death_callback(void (*callback)()) __attribute__((weak));

namespace coppice::fuzz {
namespace {

constexpr std::size_t kMostShown = 4096;                      // bytes
constexpr std::size_t kHandlerStack = std::size_t{1} << 16U;  // its own: the fault may be a stack that ran over

const std::string* last_origin = nullptr;
const std::uint8_t* last_data = nullptr;
std::size_t last_size = 0;
volatile std::sig_atomic_t shown = 0;

// Everything below runs in a signal handler: no allocation, no stdio.
class Output {
 public:
  ~Output() { flush(); }
  void put(char c) {
    if (used_ == buffer_.size()) {
      flush();
    }
    buffer_[used_++] = c;
  }
  void put(std::string_view text) {
    for (const char c : text) {
      put(c);
    }
  }
  void put_number(std::size_t number) {
    std::array<char, 20> digits{};
    std::size_t count = 0;
    do {
      digits[count++] = static_cast<char>('0' + number % 10);
      number /= 10;
    } while (number > 0);
    while (count > 0) {
      put(digits[--count]);
    }
  }
  void put_hex(std::uint8_t byte) {
    constexpr std::string_view kDigits = "0123456789abcdef";
    put(kDigits[byte >> 4U]);
    put(kDigits[byte & 15U]);
  }

 private:
  void flush() {
    for (std::size_t at = 0; at < used_;) {
      const ssize_t written = write(STDERR_FILENO, buffer_.data() + at, used_ - at);
      if (written <= 0) {
        break;
      }
      at += static_cast<std::size_t>(written);
    }
    used_ = 0;
  }

  std::array<char, 512> buffer_{};
  std::size_t used_ = 0;
};

void show() {
  if (last_origin == nullptr || shown != 0) {
    return;
  }
  shown = 1;
  Output out;
  out.put("\nstopped at ");
  out.put(*last_origin);
  out.put(", ");
  out.put_number(last_size);
  const std::size_t size = std::min(last_size, kMostShown);
  out.put(size < last_size ? " bytes, of which the first are, as text:\n" : " bytes; as text:\n");
  for (std::size_t i = 0; i < size; ++i) {
    const auto c = static_cast<char>(last_data[i]);
    if ((c >= ' ' && c <= '~' && c != '\\') || c == '\n') {
      out.put(c);
    } else {
      out.put("\\x");
      out.put_hex(last_data[i]);
    }
  }
  out.put("\nin hexadecimal (xxd -r -p makes a file of it):\n");
  for (std::size_t i = 0; i < size; ++i) {
    out.put_hex(last_data[i]);
  }
  out.put('\n');
}

void on_signal(int signal) {
  if (signal == SIGALRM) {
    Output().put("\nno progress: an input takes too long\n");
  }
  show();
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

}  // namespace

void show_last_input_when_stopped() {
  static std::array<char, kHandlerStack> handler_stack;
  stack_t stack{};
  stack.ss_sp = handler_stack.data();
  stack.ss_size = handler_stack.size();
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_ONSTACK;
  sigemptyset(&action.sa_mask);
  sigaction(SIGABRT, &action, nullptr);
  sigaction(SIGALRM, &action, nullptr);
  if (__sanitizer_set_death_callback != nullptr) {
    __sanitizer_set_death_callback(show);
    return;
  }
  sigaltstack(&stack, nullptr);
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL}) {
    sigaction(signal, &action, nullptr);
  }
}

void set_last_input(const std::string& origin, const std::uint8_t* data, std::size_t size) {
  last_origin = &origin;
  last_data = data;
  last_size = size;
}

void forget_last_input() { last_origin = nullptr; }

void expect_progress() { alarm(kStall); }

}  // namespace coppice::fuzz
