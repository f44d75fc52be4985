// The chains that a worker holds, by hash, and the one that it is putting together from blocks. Chains are shared by
// all lanes: one copy a process. The store is safe from any thread; an Assembly belongs to one.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "common/chain/chain_bytes.hpp"
#include "common/error.hpp"
#include "common/fitness/prepared_chain.hpp"

namespace coppice {

class ChainStore {
 public:
  static constexpr std::size_t kMaxChains = 4;  // the least recently added goes first

  std::shared_ptr<const PreparedChain> find(const ChainHash& hash) const;
  void add(const ChainHash& hash, std::shared_ptr<const PreparedChain> chain);
  std::vector<ChainHash> held() const;

 private:
  mutable std::mutex mutex_;
  std::deque<std::pair<ChainHash, std::shared_ptr<const PreparedChain>>> chains_;
};

// A chain on its way. Blocks may come in any order and more than once.
class Assembly {
 public:
  static constexpr std::uint64_t kMaxChainBytes = std::uint64_t{1}
                                                  << 33U;  // 8 GiB: a stranger's Control cannot ask for more

  // Errors: a size of 0 or beyond kMaxChainBytes.
  static Result<Assembly> start(const ChainHash& hash, std::uint64_t size, std::size_t block_bytes);

  const ChainHash& hash() const { return hash_; }
  std::uint64_t size() const { return size_; }
  std::size_t block_bytes() const { return block_bytes_; }
  std::size_t blocks() const { return blocks_.size(); }
  // All blocks before this one are there; block(i) is one of those.
  std::size_t leading() const { return first_missing_; }
  std::span<const std::uint8_t> block(std::size_t index) const { return blocks_[index]; }
  // Takes a block. Errors: index or length do not fit.
  Result<void> add(std::uint32_t index, std::span<const std::uint8_t> block);
  bool complete() const { return missing_ == 0; }

  // The first run of missing blocks, at most `window` long.
  struct Run {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
  };
  std::optional<Run> missing(std::uint32_t window) const;

  // Errors: the bytes do not have the hash, or do not decode. REQUIRES: complete().
  Result<std::shared_ptr<const PreparedChain>> finish() &&;

 private:
  Assembly(const ChainHash& hash, std::uint64_t size, std::size_t block_bytes);

  ChainHash hash_;
  std::uint64_t size_;
  std::size_t block_bytes_;
  std::vector<std::vector<std::uint8_t>>
      blocks_;  // empty where missing: memory grows with what came, not with promises
  std::size_t missing_;
  std::uint32_t first_missing_ = 0;  // no block before it is missing
};

}  // namespace coppice
