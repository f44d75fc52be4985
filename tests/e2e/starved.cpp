// A worker that gets no large piece of memory, for the tests: coppice-worker, but that `new` refuses what is larger
// than kMostBytes, as it does where an address space is limited.
//   starved DOMAIN
#include <cstdlib>
#include <new>

#include "common/stop.hpp"
#include "common/version.hpp"
#include "common/wire/topics.hpp"
#include "worker/serve.hpp"

namespace {
constexpr std::size_t kMostBytes = std::size_t{8} << 20U;
}

void* operator new(std::size_t size) {
  void* const memory = size > kMostBytes ? nullptr : std::malloc(size);
  if (memory == nullptr) {
    throw std::bad_alloc();
  }
  return memory;
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

int main(int argc, char** argv) {
  if (argc != 2) {
    return 2;
  }
  coppice::block_stop_signals();
  coppice::StopFlag stop;
  const coppice::StopOnSignals signals(stop);
  coppice::ServeOptions options;
  options.domain = static_cast<std::uint32_t>(std::strtoul(argv[1], nullptr, 10));
  options.protocol = coppice::wire::kProtocolVersion;
  options.version = coppice::kVersion;
  return coppice::serve(options, stop) ? 0 : 1;
}
