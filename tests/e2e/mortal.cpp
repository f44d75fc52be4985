// A worker that some tree kills, for the tests: coppice-worker (its own main), but that decoding a task with a tree of
// COPPICE_DEADLY_NODES nodes ends the process by SIGKILL (the linker puts __wrap_ in the decoder's place); only in
// workers, or with COPPICE_DEADLY_APART also where the coordinator evaluates it in a process of its own.
#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>

#include "common/wire/codec.hpp"

namespace {

using Decoded = coppice::Result<coppice::wire::DecodedTask>;
using Payload = std::span<const std::uint8_t>;

bool is_apart() {
  std::ifstream file("/proc/self/cmdline");
  const std::string arguments{std::istreambuf_iterator<char>(file), {}};
  return arguments.find("--apart") != std::string::npos;
}

bool is_deadly(const coppice::Tree& tree) {
  const char* const nodes = std::getenv("COPPICE_DEADLY_NODES");
  return nodes != nullptr && tree.size() == std::strtoul(nodes, nullptr, 10) &&
         (!is_apart() || std::getenv("COPPICE_DEADLY_APART") != nullptr);
}

}  // namespace

// NOLINTBEGIN(bugprone-reserved-identifier): the linker's names
extern "C" Decoded __real__ZN7coppice4wire11TaskDecoder6decodeESt4spanIKhLm18446744073709551615EE(
    coppice::wire::TaskDecoder* decoder, Payload payload);

extern "C" Decoded __wrap__ZN7coppice4wire11TaskDecoder6decodeESt4spanIKhLm18446744073709551615EE(
    coppice::wire::TaskDecoder* decoder, Payload payload) {
  Decoded decoded = __real__ZN7coppice4wire11TaskDecoder6decodeESt4spanIKhLm18446744073709551615EE(decoder, payload);
  if (decoded && std::any_of(decoded->trees.begin(), decoded->trees.end(), is_deadly)) {
    std::raise(SIGKILL);
  }
  return decoded;
}
// NOLINTEND(bugprone-reserved-identifier)
