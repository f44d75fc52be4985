#include "coordinator/evolution/deme_graph.hpp"

#include <algorithm>
#include <utility>

#include "common/check.hpp"
#include "common/evolution/migration.hpp"

namespace coppice {

DemeGraph::DemeGraph(const EvolveConfig& config, std::uint32_t epochs, std::vector<Stood> demes)
    : config_(config),
      epochs_(epochs_of(config.ga)),
      first_(epochs == 0 ? 0 : epochs - 1),
      next_(config.ga.demes, epochs),
      busy_(config.ga.demes, false),
      next_row_(epochs) {
  COPPICE_CHECK(demes.size() == (epochs == 0 ? 0 : config.ga.demes));
  for (std::uint32_t deme = 0; deme < demes.size(); ++deme) {
    Column& before = column(first_);
    before.cells[deme] = {std::move(demes[deme].deme), std::move(demes[deme].emigrants), {}};
    ++before.ended;
    before.given = true;
  }
}

DemeGraph::Column& DemeGraph::column(std::uint32_t epoch) {
  COPPICE_CHECK(epoch >= first_);
  while (epoch - first_ >= columns_.size()) {
    const auto added = first_ + static_cast<std::uint32_t>(columns_.size());
    columns_.push_back({.cells = std::vector<Cell>(config_.ga.demes), .senders = senders_of(config_, added)});
  }
  return columns_[epoch - first_];
}

bool DemeGraph::can_begin(std::uint32_t deme, std::uint32_t epoch) {
  if (busy_[deme] || epoch >= epochs_) {
    return false;
  }
  const auto& senders = column(epoch).senders;
  return epoch == 0 || senders.empty() || column(epoch - 1).cells[senders[deme]].deme != nullptr;
}

EpochTask DemeGraph::task_of(std::uint32_t deme, std::uint32_t epoch) {
  EpochTask task{.number = deme, .until = epoch_end(config_.ga, epoch), .deme = nullptr, .migrants = {}};
  if (epoch > 0) {
    const auto& senders = column(epoch).senders;
    Column& before = column(epoch - 1);
    task.deme = before.cells[deme].deme;
    if (!senders.empty()) {
      task.migrants = before.cells[senders[deme]].emigrants;
    }
  }
  return task;
}

std::vector<EpochTask> DemeGraph::take_ready() {
  std::vector<std::uint32_t> ready;
  for (std::uint32_t deme = 0; deme < next_.size(); ++deme) {
    if (can_begin(deme, next_[deme])) {
      ready.push_back(deme);
    }
  }
  std::stable_sort(ready.begin(), ready.end(), [&](std::uint32_t a, std::uint32_t b) { return next_[a] < next_[b]; });
  std::vector<EpochTask> tasks;
  for (const std::uint32_t deme : ready) {
    tasks.push_back(task_of(deme, next_[deme]));
    busy_[deme] = true;
    ++running_;
  }
  return tasks;
}

void DemeGraph::settle(std::uint32_t deme, EpochResult result) {
  COPPICE_CHECK(deme < next_.size() && busy_[deme]);
  Column& ended = column(next_[deme]);
  COPPICE_CHECK(result.deme.generations == epoch_end(config_.ga, next_[deme]));
  ended.cells[deme] = {std::make_shared<const Deme>(std::move(result.deme)), std::move(result.emigrants),
                       std::move(result.records)};
  ++ended.ended;
  ++next_[deme];
  busy_[deme] = false;
  --running_;
  forget_old();
}

std::optional<EpochRow> DemeGraph::take_row() {
  if (next_row_ >= epochs_ || next_row_ - first_ >= columns_.size()) {
    return std::nullopt;
  }
  Column& whole = columns_[next_row_ - first_];
  if (whole.ended < whole.cells.size()) {
    return std::nullopt;
  }
  EpochRow row{.epoch = next_row_, .demes = {}, .records = {}};
  for (Cell& cell : whole.cells) {
    row.demes.push_back(cell.deme);
    row.records.push_back(std::move(cell.records));
  }
  whole.given = true;
  ++next_row_;
  forget_old();
  return row;
}

// A column is needed until it was given, and all who begin behind it have ended theirs.
void DemeGraph::forget_old() {
  while (columns_.size() > 1 && columns_.front().given && columns_[1].ended == columns_[1].cells.size()) {
    columns_.pop_front();
    ++first_;
  }
}

}  // namespace coppice
