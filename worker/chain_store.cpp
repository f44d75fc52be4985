#include "worker/chain_store.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "common/check.hpp"

namespace coppice {

std::shared_ptr<const PreparedChain> ChainStore::find(const ChainHash& hash) const {
  const std::lock_guard lock(mutex_);
  const auto found =
      std::find_if(chains_.begin(), chains_.end(), [&](const auto& entry) { return entry.first == hash; });
  return found == chains_.end() ? nullptr : found->second;
}

void ChainStore::add(const ChainHash& hash, std::shared_ptr<const PreparedChain> chain) {
  const std::lock_guard lock(mutex_);
  chains_.emplace_back(hash, std::move(chain));
  if (chains_.size() > kMaxChains) {
    chains_.pop_front();
  }
}

std::vector<ChainHash> ChainStore::held() const {
  const std::lock_guard lock(mutex_);
  std::vector<ChainHash> hashes;
  hashes.reserve(chains_.size());
  for (const auto& entry : chains_) {
    hashes.push_back(entry.first);
  }
  return hashes;
}

Assembly::Assembly(const ChainHash& hash, std::uint64_t size, std::size_t block_bytes)
    : hash_(hash),
      size_(size),
      block_bytes_(block_bytes),
      blocks_((size + block_bytes - 1) / block_bytes),
      missing_(blocks_.size()) {}

Result<Assembly> Assembly::start(const ChainHash& hash, std::uint64_t size, std::size_t block_bytes) {
  if (size == 0 || size > kMaxChainBytes) {
    return bad_input(fmt::format("the coordinator offers a chain of {} bytes: expected 1 to {}", size, kMaxChainBytes));
  }
  return Assembly(hash, size, block_bytes);
}

Result<void> Assembly::add(std::uint32_t index, std::span<const std::uint8_t> block) {
  if (index >= blocks_.size()) {
    return bad_input(fmt::format("chain block {} of {}", index, blocks_.size()));
  }
  const std::size_t begin = index * block_bytes_;
  const std::size_t expected = std::min<std::size_t>(block_bytes_, size_ - begin);
  if (block.size() != expected) {
    return bad_input(fmt::format("chain block {} has {} bytes: expected {}", index, block.size(), expected));
  }
  if (blocks_[index].empty()) {
    blocks_[index].assign(block.begin(), block.end());
    --missing_;
    while (first_missing_ < blocks_.size() && !blocks_[first_missing_].empty()) {
      ++first_missing_;
    }
  }
  return {};
}

std::optional<Assembly::Run> Assembly::missing(std::uint32_t window) const {
  if (complete()) {
    return std::nullopt;
  }
  Run run{first_missing_, 0};
  while (run.count < window && run.first + run.count < blocks_.size() && blocks_[run.first + run.count].empty()) {
    ++run.count;
  }
  return run;
}

Result<std::shared_ptr<const PreparedChain>> Assembly::finish() && {
  COPPICE_CHECK(complete());
  if (hash_of(blocks_) != hash_) {
    return bad_input("the chain's bytes do not have its hash");
  }
  auto chain = chain_from_pieces(std::move(blocks_));
  if (!chain) {
    return tl::unexpected(chain.error());
  }
  return PreparedChain::make(std::make_shared<const Chain>(std::move(*chain)));
}

}  // namespace coppice
