#include "common/fitness/prepared_chain.hpp"

namespace coppice {

PreparedChain::PreparedChain(std::shared_ptr<const Chain> chain, Form form) : chain_(std::move(chain)) {
  policy_.reserve(chain_->states());
  for (const ActionId action : chain_->parts().policy) {
    policy_.push_back(static_cast<std::uint8_t>(action));
  }
  if (form == Form::tables) {
    rows_.emplace(*chain_);
    columns();
  }
}

std::shared_ptr<const PreparedChain> PreparedChain::make(std::shared_ptr<const Chain> chain) {
  const Form form = AliasRows::fits(*chain) ? Form::tables : Form::lazy;
  return make(std::move(chain), form);
}

std::shared_ptr<const PreparedChain> PreparedChain::make(std::shared_ptr<const Chain> chain, Form form) {
  return std::shared_ptr<const PreparedChain>(new PreparedChain(std::move(chain), form));
}

const StateColumns& PreparedChain::columns() const {
  std::call_once(columns_made_, [this] { columns_.emplace(chain_->vocabulary(), chain_->parts().features); });
  return *columns_;
}

}  // namespace coppice
