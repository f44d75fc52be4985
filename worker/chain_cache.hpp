// Chains on disk, so that a worker that is started anew is not sent again what it had. A folder holds a file for each
// chain, HASH.chain, with the chain's canonical bytes (common/chain/chain_bytes.hpp) from the first on, as many whole
// blocks of them as have come: a worker that was killed in the middle of a transfer goes on behind them.
//
// Nothing in the folder is trusted: what is read goes through the same hash as what comes over the network, and a file
// whose bytes do not have it is removed. Workers of one host may share a folder; one writes a file (flock), the others
// read what is there. A disk that is full costs the cache, not the work. Belongs to one thread.
#pragma once

#include <cstddef>
#include <filesystem>

#include "common/error.hpp"
#include "worker/chain_store.hpp"

namespace coppice {

class ChainCache {
 public:
  static constexpr std::size_t kMaxFiles = ChainStore::kMaxChains;  // the least recently used goes first

  // Makes the folder if need be. Errors (bad_input) name --cache: no such place, or not to be written.
  static Result<ChainCache> open(std::filesystem::path folder);
  ChainCache(ChainCache&& other) noexcept;
  ChainCache& operator=(ChainCache&&) = delete;
  ~ChainCache();

  // Begins with a chain of which nothing has come yet: adds the blocks that are on disk. Returns how many.
  std::size_t resume(Assembly& assembly);
  // Writes the blocks that came since, as far as none before them is missing.
  void keep(const Assembly& assembly);
  // The chain is whole and its bytes have its hash: its file stays.
  void done();
  // They do not: its file goes.
  void discard();

 private:
  explicit ChainCache(std::filesystem::path folder) : folder_(std::move(folder)) {}

  bool read_blocks(Assembly& assembly, std::size_t length) const;
  void close();
  void complain(const char* what, int error);
  void drop_oldest() const;

  std::filesystem::path folder_;
  std::filesystem::path path_;  // of the chain at hand
  int file_ = -1;               // of it
  bool writes_ = false;         // it is ours to write
  std::size_t written_ = 0;     // blocks
  bool complained_ = false;
};

}  // namespace coppice
