// A worker that lies, for the tests: coppice-worker, but that some of its answers are changed on their way out (the
// linker puts __wrap_ in the encoder's place).
//   liar DOMAIN HONEST     its first HONEST answers are true, then none is
// It goes to the coordinator on this machine, or on COPPICE_STRANGER_HOST.
#include <atomic>
#include <cstdlib>
#include <string>
#include <vector>

#include "common/stop.hpp"
#include "common/version.hpp"
#include "common/wire/codec.hpp"
#include "common/wire/topics.hpp"
#include "worker/serve.hpp"

namespace {
std::atomic<long> honest{0};
}

// NOLINTBEGIN(bugprone-reserved-identifier): the linker's names
extern "C" std::vector<std::uint8_t>
__real__ZN7coppice4wire14encode_talliesESt4spanIKNS_5TallyELm18446744073709551615EE(
    std::span<const coppice::Tally> tallies);

extern "C" std::vector<std::uint8_t>
__wrap__ZN7coppice4wire14encode_talliesESt4spanIKNS_5TallyELm18446744073709551615EE(
    std::span<const coppice::Tally> tallies) {
  std::vector<coppice::Tally> said(tallies.begin(), tallies.end());
  if (honest.fetch_sub(1) <= 0) {
    for (coppice::Tally& tally : said) {
      tally.matches = tally.steps - tally.matches;
      for (std::int64_t& score : tally.scores) {
        ++score;
      }
    }
  }
  return __real__ZN7coppice4wire14encode_talliesESt4spanIKNS_5TallyELm18446744073709551615EE(said);
}
// NOLINTEND(bugprone-reserved-identifier)

int main(int argc, char** argv) {
  if (argc != 3) {
    return 2;
  }
  coppice::block_stop_signals();
  coppice::StopFlag stop;
  const coppice::StopOnSignals signals(stop);
  coppice::ServeOptions options;
  options.domain = static_cast<std::uint32_t>(std::strtoul(argv[1], nullptr, 10));
  options.protocol = coppice::wire::kProtocolVersion;
  options.version = coppice::kVersion;
  if (const char* host = std::getenv("COPPICE_STRANGER_HOST"); host != nullptr) {
    options.coordinator = host;
  }
  honest = std::strtol(argv[2], nullptr, 10);
  return coppice::serve(options, stop) ? 0 : 1;
}
