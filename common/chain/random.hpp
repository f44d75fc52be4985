// The two sources of chance, both bit-exact on every machine.
//  * Philox4x32-10 (Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC'11): counter-based, so a
//    draw is a pure function of (seed, stream, position). Roll-outs and the genetic algorithm use it: a draw
//    belongs to its place, never to the thread or worker that makes it.
//  * Xoshiro256++ (Blackman & Vigna, 2019): sequential and faster, for the learning loop, which is serial.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

namespace coppice {

__extension__ using Uint128 = unsigned __int128;

// One block of Philox4x32-10: 128 random bits for a 128-bit counter and a 64-bit key.
std::array<std::uint32_t, 4> philox4x32(std::array<std::uint32_t, 4> counter, std::array<std::uint32_t, 2> key);

// What a stream of draws is for. Values are part of every result's identity: never renumber.
enum class Purpose : std::uint32_t {
  rollout = 1,
  mixing = 2,
  redraw = 3,
  breeding = 4,
  growing = 5,
  simulating = 6,
  starting = 7,
  migrating = 8,
  meeting = 9,
};

// 64 random bits at a place: 2^32 positions in each of 2^32 x 2^32 streams of each purpose and seed.
struct DrawAt {
  std::uint64_t seed = 0;
  Purpose purpose = Purpose::rollout;
  std::uint32_t generation = 0;
  std::uint32_t stream = 0;  // roll-out, or slot
  std::uint32_t position = 0;
};
std::uint64_t draw(const DrawAt& place);

// Many short draws of one stream: out[i] = 32 random bits of position i. A block of the generator gives four of them,
// block b those of the positions 4 b to 4 b + 3. `place.position` is not used.
void draw_words(const DrawAt& place, std::span<std::uint32_t> out);

// Floor(x * n / 2^64): a number in [0, n) from 64 random bits, without division (Lemire, "Fast random integer
// generation in an interval", TOMACS 2019). Exactly uniform once the few x with accept(x, n) false are redrawn.
inline std::uint64_t scale(std::uint64_t x, std::uint64_t n) {
  return static_cast<std::uint64_t>((static_cast<Uint128>(x) * n) >> 64U);
}
inline bool accept(std::uint64_t x, std::uint64_t n) {
  const std::uint64_t low = x * n;
  return low >= n || low >= (0 - n) % n;
}

// A sequence of draws from one Philox stream; for code that needs "the next one" (breeding).
class Stream {
 public:
  Stream(std::uint64_t seed, Purpose purpose, std::uint32_t generation, std::uint32_t stream)
      : place_{seed, purpose, generation, stream, 0} {}

  std::uint64_t next() {
    const std::uint64_t bits = draw(place_);
    ++place_.position;
    return bits;
  }
  // Uniform in [0, n). REQUIRES: n > 0.
  std::uint64_t below(std::uint64_t n);
  // True with probability p; exact to 2^-53.
  bool chance(double p) { return static_cast<double>(next() >> 11U) * 0x1.0p-53 < p; }

 private:
  DrawAt place_;
};

class Xoshiro256 {
 public:
  // Any seed is good: the state is filled by SplitMix64.
  explicit Xoshiro256(std::uint64_t seed);
  // Goes on where another stood. Nothing: all zeros, of which no draw would ever be another number than zero.
  static std::optional<Xoshiro256> from_state(const std::array<std::uint64_t, 4>& state);
  const std::array<std::uint64_t, 4>& state() const { return state_; }

  std::uint64_t next() {
    const std::uint64_t result = rotate(state_[0] + state_[3], 23) + state_[0];
    const std::uint64_t shifted = state_[1] << 17U;
    state_[2] ^= state_[0];
    state_[3] ^= state_[1];
    state_[1] ^= state_[2];
    state_[0] ^= state_[3];
    state_[2] ^= shifted;
    state_[3] = rotate(state_[3], 45);
    return result;
  }
  // Uniform in [0, n). REQUIRES: n > 0.
  std::uint64_t below(std::uint64_t n) {
    std::uint64_t x = next();
    while (!accept(x, n)) {
      x = next();
    }
    return scale(x, n);
  }

 private:
  static std::uint64_t rotate(std::uint64_t x, unsigned k) { return (x << k) | (x >> (64U - k)); }
  std::array<std::uint64_t, 4> state_;
};

}  // namespace coppice
