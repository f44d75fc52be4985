// Packs epochs of demes into the payloads of the contract (idl/coppice.idl), as codec.hpp does trees and tallies, and
// as strictly: whatever a decode function returns passed check_search() and EpochCheck, or is a result that such a
// task can have. Equal values have equal bytes and the reverse.
//
// Little-endian; var: an unsigned number in groups of 7 bits, the low ones first, without empty groups at the end; zig:
// a signed one as var, 2 n or -2 n - 1.
//
// Task payload:    {configuration} {task}
//   configuration: u32 bytes, u8 with founders, the value of each of keys_of() in their order: integer i64 (seed u64),
//                  number f64, text u16 bytes and they; then u8 rules, each {i32 right, i32 wrong, u8 conditions, each
//                  text}. The rule that picks an answer is no business of a worker; founders travel only with demes
//                  that begin.
//   task:          u32 deme, u32 until, u8 counts meanings, u8 begins; unless it begins: {deme} {individuals}
//   (migrants) deme:          u32 generations, {individuals} (population) {individuals} (archive) individuals:   u32
//   count, each {tree} var nodes, var matches, var steps, zig score for each objective
// Answer payload:  {deme} {individuals} (emigrants), u32 records, each {tree} f64 fitness, f64 agreement, f64 mean
// fitness,
//                  f64 mean agreement, f64 mean nodes, u32 distinct trees, u32 meanings, u32 evaluations
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/error.hpp"
#include "common/evolution/epoch.hpp"
#include "common/tree/tree_checker.hpp"

namespace coppice::wire {

std::vector<std::uint8_t> encode_configuration(const EvolveConfig& config, bool with_founders);

// `configuration` is that of a run as encode_configuration() packs it: with founders if the deme begins.
std::vector<std::uint8_t> encode_epoch_task(std::span<const std::uint8_t> configuration, const EpochTask& task);
// REQUIRES: every record is of the generation that its place says, and its champion too.
std::vector<std::uint8_t> encode_epoch_result(const EpochResult& result);

// Bytes that no payload of such a run exceeds, neither way; for whoever must know beforehand that epochs fit into
// messages.
std::size_t most_epoch_bytes(const EvolveConfig& config, std::size_t objectives);

struct DecodedEpoch {
  std::shared_ptr<const EvolveConfig> config;
  EpochTask task;
};

// For tasks that come one after another on one chain. Belongs to one thread.
class EpochDecoder {
 public:
  // The chain must outlive it.
  explicit EpochDecoder(const Chain& chain) : chain_(chain), checker_(chain.vocabulary()) {}

  Result<DecodedEpoch> decode_task(std::span<const std::uint8_t> payload);
  // The result of a task that was sent. Errors also: a deme that this task cannot lead to.
  Result<EpochResult> decode_result(std::span<const std::uint8_t> payload,
                                    const std::shared_ptr<const EvolveConfig>& config, const EpochTask& task);

 private:
  void use(std::shared_ptr<const EvolveConfig> config);
  Result<void> read_configuration(std::span<const std::uint8_t> bytes);
  Result<std::vector<Individual>> read_individuals(std::span<const std::uint8_t>& bytes);
  Result<Deme> read_deme(std::span<const std::uint8_t>& bytes);
  Result<Tree> read_tree(std::span<const std::uint8_t>& bytes);

  const Chain& chain_;
  TreeChecker checker_;
  std::vector<std::uint8_t> configuration_;  // as it came last
  std::shared_ptr<const EvolveConfig> config_;
  std::optional<EpochCheck> check_;  // against it
};

}  // namespace coppice::wire
