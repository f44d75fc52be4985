// Inputs near a corpus: each is one of its files, or the head of one and the tail of another, with a few random
// changes. Input i is a pure function of (corpus, seed, i), so any of them can be made again alone. Immutable; safe to
// share between threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace coppice::fuzz {

using Bytes = std::vector<std::uint8_t>;

inline constexpr std::size_t kMaxInput = std::size_t{1} << 16U;  // bytes of a mutated input

struct Corpus {
  std::vector<Bytes> good;  // accepted as they are: most inputs begin with one of them
  std::vector<Bytes> bad;   // refused
};

class Mutation {
 public:
  // REQUIRES: corpus is not empty.
  Mutation(Corpus corpus, std::uint32_t seed);

  // Overwrites `input`, whose memory is reused.
  void make(std::uint32_t i, Bytes& input) const;

 private:
  std::vector<Bytes> files_;  // the good ones first
  std::size_t good_;
  std::uint32_t seed_;
};

}  // namespace coppice::fuzz
