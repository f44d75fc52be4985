#include "common/fitness/prepared_chain.hpp"

namespace coppice {

PreparedChain::PreparedChain(std::shared_ptr<const Chain> chain, AliasRows rows)
    : chain_(std::move(chain)), columns_(chain_->vocabulary(), chain_->parts().features), rows_(std::move(rows)) {
  policy_.reserve(chain_->states());
  for (const ActionId action : chain_->parts().policy) {
    policy_.push_back(static_cast<std::uint8_t>(action));
  }
}

Result<std::shared_ptr<const PreparedChain>> PreparedChain::make(std::shared_ptr<const Chain> chain) {
  auto rows = AliasRows::make(*chain);
  if (!rows) {
    return tl::unexpected(rows.error());
  }
  return std::shared_ptr<const PreparedChain>(new PreparedChain(std::move(chain), std::move(*rows)));
}

}  // namespace coppice
