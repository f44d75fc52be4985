#include "coordinator/bench/transfer.hpp"

#include <algorithm>

#include "common/chain/chain_bytes.hpp"
#include "coordinator/bench/echo.hpp"
#include "coordinator/fleet/fleet.hpp"

namespace coppice {
namespace {

// From the worker's start until it holds the chain. What the coordinator does before is not part of it.
Result<double> until_held(const std::shared_ptr<const Chain>& chain, const TransferSettings& settings,
                          const StopFlag& stop) {
  FleetOptions options;
  options.local_workers = 1;
  options.worker_program = settings.worker_program;
  auto dispatch = Fleet::open(chain, std::move(options), stop);
  if (!dispatch) {
    return tl::unexpected(dispatch.error());
  }
  const Stopwatch watch;  // the worker was started a moment ago, as the last thing that open() does
  if (auto ok = (*dispatch)->await_workers(1); !ok) {
    return tl::unexpected(ok.error());
  }
  return watch.seconds();
}

// A chain of one state in which nothing was ever tried.
Result<std::shared_ptr<const Chain>> tiny_chain(const Chain& like) {
  ChainParts parts;
  parts.vocabulary = like.vocabulary();
  const auto features = like.features_of(0);
  parts.features.assign(features.begin(), features.end());
  parts.row_begin.assign(like.actions() + 1, 0);
  parts.reward_sum.assign(like.actions(), 0.0);
  parts.q.assign(like.actions(), 0.0);
  parts.policy = {ActionId{0}};
  parts.visits = {1};
  auto chain = Chain::make(std::move(parts));
  if (!chain) {
    return tl::unexpected(std::move(chain).error());
  }
  return std::make_shared<const Chain>(std::move(*chain));
}

}  // namespace

Result<Transfer> measure_transfer(const std::shared_ptr<const Chain>& chain, const TransferSettings& settings,
                                  const StopFlag& stop) {
  const auto tiny = tiny_chain(*chain);
  if (!tiny) {
    return tl::unexpected(tiny.error());
  }
  auto echo = Echo::open(settings.worker_program, 1, stop);
  if (!echo) {
    return tl::unexpected(echo.error());
  }
  Transfer transfer;
  transfer.bytes = to_bytes(*chain).size();
  const Echo::Traffic blocks = Echo::chain_traffic(transfer.bytes);
  transfer.blocks = blocks.batches;
  std::vector<double> starts;
  std::vector<double> seconds;
  std::vector<double> bare;
  std::vector<double> shares;
  for (std::uint32_t repetition = 0; repetition < settings.repetitions; ++repetition) {
    const auto start = until_held(*tiny, settings, stop);
    const auto whole = start ? until_held(chain, settings, stop) : start;
    if (!whole) {
      return tl::unexpected(whole.error());
    }
    const Stopwatch watch;
    if (auto ok = (*echo)->exchange(blocks); !ok) {
      return tl::unexpected(ok.error());
    }
    bare.push_back(watch.seconds());
    starts.push_back(*start);
    seconds.push_back(std::max(*whole - *start, 1e-9));
    shares.push_back(bare.back() / seconds.back());
  }
  transfer.start_seconds = spread_of(starts);
  transfer.seconds = spread_of(seconds);
  transfer.bare_seconds = spread_of(bare);
  transfer.share = spread_of(shares);
  return transfer;
}

}  // namespace coppice
