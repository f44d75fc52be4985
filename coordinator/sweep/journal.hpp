// The runs of a sweep that have ended, one JSON object a line, in the order of their ends: what a sweep that was
// interrupted or killed goes on from. A line counts only for the very run that it names: chain, configuration with its
// seed, and episodes; a line that was cut short counts for nothing. A line can be revoked by a later one: when a worker
// is found to lie, the runs that ended while it served are run again.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/chain/chain_bytes.hpp"
#include "common/error.hpp"
#include "common/tree/vocabulary.hpp"
#include "coordinator/sweep/plan.hpp"
#include "coordinator/sweep/sweep.hpp"

namespace coppice {

class SweepJournal {
 public:
  // Reads what is there, if the file exists, and goes on in it. Errors: the file cannot be read or written.
  static Result<SweepJournal> open(const std::filesystem::path& path, const ChainHash& chain, std::uint64_t episodes,
                                   const Vocabulary& vocabulary);
  SweepJournal(SweepJournal&& other) noexcept;
  SweepJournal& operator=(SweepJournal&&) = delete;
  ~SweepJournal();

  // Null: this run has not ended yet.
  const SweepResult* find(const EvolveConfig& config) const;
  // The number of the first line (from 1) whose run is none of these, if there is one: then the file is of another
  // study, or of the same one with other settings. Lines that cannot be read do not count.
  std::optional<std::size_t> line_beside(const std::vector<SweepRun>& runs) const;
  // Forgets every run that add() was called for, in the file as well. Returns how many.
  Result<std::size_t> revoke_added();
  // Written through to the disk.
  Result<void> add(const EvolveConfig& config, const SweepResult& result);

 private:
  SweepJournal(std::filesystem::path path, const ChainHash& chain, std::uint64_t episodes,
               const Vocabulary& vocabulary);

  void read(const std::string& text);
  std::string key_of(const EvolveConfig& config) const;
  Result<void> write_line(const std::string& line) const;

  std::filesystem::path path_;
  std::string chain_;
  std::uint64_t episodes_;
  Vocabulary vocabulary_;
  std::map<std::string, SweepResult> results_;
  std::map<std::string, std::size_t> lines_;  // by key_of(), the line of every run that was read, of whatever chain
  std::vector<EvolveConfig> added_;
  int file_ = -1;
};

}  // namespace coppice
