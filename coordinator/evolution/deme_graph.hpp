// Which epoch of which deme can begin: the data-flow graph of a run. Deme d begins an epoch as soon as it and the deme
// that sends it migrants have ended the one before; nobody waits for all. Pure: no clock, no thread, no chance but that
// of the configuration, so the tasks that it gives out are the same whatever the order in which epochs end.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "common/evolution/config.hpp"
#include "common/evolution/deme.hpp"
#include "common/evolution/epoch.hpp"

namespace coppice {

// An epoch that every deme has ended.
struct EpochRow {
  std::uint32_t epoch = 0;
  std::vector<std::shared_ptr<const Deme>> demes;      // [demes]
  std::vector<std::vector<GenerationRecord>> records;  // [demes][generations of the epoch]
};

class DemeGraph {
 public:
  explicit DemeGraph(const EvolveConfig& config) : DemeGraph(config, 0, {}) {}
  // Goes on behind `epochs` epochs, 1 or more, where the demes stood thus. REQUIRES: one of each deme, with its
  // emigrants.
  struct Stood {
    std::shared_ptr<const Deme> deme;
    std::vector<Individual> emigrants;
  };
  DemeGraph(const EvolveConfig& config, std::uint32_t epochs, std::vector<Stood> demes);

  // Epochs that can begin and were not given out before, the earliest first.
  std::vector<EpochTask> take_ready();
  // REQUIRES: take_ready() gave this deme's epoch, and it was not settled yet.
  void settle(std::uint32_t deme, EpochResult result);
  // Rows in the order of epochs, each once, as soon as it is whole.
  std::optional<EpochRow> take_row();

  // Epochs given out and not settled.
  std::size_t running() const { return running_; }

 private:
  struct Cell {
    std::shared_ptr<const Deme> deme;  // null: not ended
    std::vector<Individual> emigrants;
    std::vector<GenerationRecord> records;
  };
  struct Column {                        // an epoch
    std::vector<Cell> cells;             // [demes]
    std::vector<std::uint32_t> senders;  // of those who begin it, [demes] or empty
    std::size_t ended = 0;
    bool given = false;  // by take_row()
  };

  bool can_begin(std::uint32_t deme, std::uint32_t epoch);
  EpochTask task_of(std::uint32_t deme, std::uint32_t epoch);
  Column& column(std::uint32_t epoch);
  void forget_old();

  const EvolveConfig config_;
  const std::uint32_t epochs_;
  std::uint32_t first_ = 0;          // epoch of the first column
  std::deque<Column> columns_;       // what is still needed, epoch by epoch
  std::vector<std::uint32_t> next_;  // [demes], the epoch that each does or will do next
  std::vector<bool> busy_;           // [demes]
  std::uint32_t next_row_ = 0;
  std::size_t running_ = 0;
};

}  // namespace coppice
