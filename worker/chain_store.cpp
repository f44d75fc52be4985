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
  for (const auto& entry : chains_) {
    hashes.push_back(entry.first);
  }
  return hashes;
}

Assembly::Assembly(const ChainHash& hash, std::uint64_t size, std::size_t block_bytes)
    : hash_(hash),
      size_(size),
      block_bytes_(block_bytes),
      present_((size + block_bytes - 1) / block_bytes),
      missing_(present_.size()) {}

Result<Assembly> Assembly::start(const ChainHash& hash, std::uint64_t size, std::size_t block_bytes) {
  if (size == 0 || size > kMaxChainBytes) {
    return bad_input(fmt::format("the coordinator offers a chain of {} bytes: expected 1 to {}", size, kMaxChainBytes));
  }
  return Assembly(hash, size, block_bytes);
}

Result<void> Assembly::add(std::uint32_t index, std::span<const std::uint8_t> block) {
  if (index >= present_.size()) {
    return bad_input(fmt::format("chain block {} of {}", index, present_.size()));
  }
  const std::size_t begin = index * block_bytes_;
  const std::size_t expected = std::min<std::size_t>(block_bytes_, size_ - begin);
  if (block.size() != expected) {
    return bad_input(fmt::format("chain block {} has {} bytes: expected {}", index, block.size(), expected));
  }
  if (!present_[index]) {
    bytes_.resize(std::max(bytes_.size(), begin + expected));
    std::copy(block.begin(), block.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(begin));
    present_[index] = true;
    --missing_;
    while (first_missing_ < present_.size() && present_[first_missing_]) {
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
  while (run.count < window && run.first + run.count < present_.size() && !present_[run.first + run.count]) {
    ++run.count;
  }
  return run;
}

Result<std::shared_ptr<const PreparedChain>> Assembly::finish() && {
  COPPICE_CHECK(complete());
  if (hash_of(bytes_) != hash_) {
    return bad_input("the chain's bytes do not have its hash");
  }
  auto chain = chain_from_bytes(bytes_);
  bytes_ = {};  // before the chain is prepared: two copies at once at most
  if (!chain) {
    return tl::unexpected(chain.error());
  }
  return PreparedChain::make(std::make_shared<const Chain>(std::move(*chain)));
}

}  // namespace coppice
