// A worker that lies, for the tests: coppice-worker, but that some of its answers are changed on their way out.
//   liar DOMAIN HONEST     its first HONEST answers are true, then none is
// It goes to the coordinator on this machine, or on COPPICE_STRANGER_HOST.
#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <span>

#include "common/stop.hpp"
#include "common/version.hpp"
#include "common/wire/topics.hpp"
#include "worker/serve.hpp"

namespace {

std::atomic<long> honest{0};

void lie(std::span<coppice::Tally> tallies) {
  if (honest.fetch_sub(1) > 0) {
    return;
  }
  for (coppice::Tally& tally : tallies) {
    tally.matches = tally.steps - tally.matches;
    for (std::int64_t& score : tally.scores) {
      ++score;
    }
  }
}

// The population in another order: as well-formed as the truth, and another answer.
void lie_about_an_epoch(coppice::EpochResult& result) {
  if (honest.fetch_sub(1) <= 0) {
    auto& population = result.deme.population;
    std::rotate(population.begin(), population.begin() + 1, population.end());
  }
}

}  // namespace

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
  options.before_answer = lie;
  options.before_epoch_answer = lie_about_an_epoch;
  if (const char* host = std::getenv("COPPICE_STRANGER_HOST"); host != nullptr) {
    options.coordinator = host;
  }
  honest = std::strtol(argv[2], nullptr, 10);
  return coppice::serve(options, stop) ? 0 : 1;
}
