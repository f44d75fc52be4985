// The other kind of work that a lane does: an epoch of a deme, from the bytes of a task to those of an answer. Belongs
// to one thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "common/error.hpp"
#include "common/evolution/epoch.hpp"
#include "common/fitness/prepared_chain.hpp"
#include "common/wire/epoch_codec.hpp"

namespace coppice {

class Epochs {
 public:
  explicit Epochs(std::shared_ptr<const PreparedChain> chain)
      : chain_(std::move(chain)), decoder_(chain_->chain()), runner_(chain_) {}

  const std::shared_ptr<const PreparedChain>& chain() const { return chain_; }

  // `go_on` as EpochRunner::run(); `before_answer` (tests only) may be empty. Errors: interrupted; what does not decode
  // or does not fit the chain.
  Result<std::vector<std::uint8_t>> run(std::span<const std::uint8_t> payload,
                                        const std::function<bool(std::size_t)>& go_on,
                                        const std::function<void(EpochResult&)>& before_answer = {});

 private:
  std::shared_ptr<const PreparedChain> chain_;
  wire::EpochDecoder decoder_;
  EpochRunner runner_;
};

}  // namespace coppice
