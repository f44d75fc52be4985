#include "tests/fuzz/mutation.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>

#include "common/chain/random.hpp"
#include "common/check.hpp"

namespace coppice::fuzz {
namespace {

// Where counters wrap and where our own limits lie.
constexpr std::array<std::uint64_t, 26> kIntegers = {0,
                                                     1,
                                                     2,
                                                     3,
                                                     16,
                                                     17,
                                                     32,
                                                     33,
                                                     63,
                                                     64,
                                                     65,
                                                     127,
                                                     128,
                                                     255,
                                                     256,
                                                     4095,
                                                     4096,
                                                     4097,
                                                     0x7FFF,
                                                     0xFFFF,
                                                     0x10001,
                                                     1U << 20U,
                                                     0x7FFFFFFF,
                                                     0xFFFFFFFF,
                                                     0x7FFFFFFFFFFFFFFF,
                                                     0xFFFFFFFFFFFFFFFF};
constexpr std::array<std::string_view, 12> kNumbers = {
    "0", "1", "-1", "255", "256", "4097", "4294967296", "18446744073709551616", "1e308", "1e999", "nan", "-inf"};

bool is_digit(std::uint8_t byte) { return byte >= '0' && byte <= '9'; }

bool is_word(std::uint8_t byte) {
  return is_digit(byte) || (byte >= 'a' && byte <= 'z') || (byte >= 'A' && byte <= 'Z') || byte == '_';
}

// One input in the making.
class Draft {
 public:
  Draft(const std::vector<Bytes>& files, Xoshiro256& random, Bytes& input)
      : files_(files), random_(random), input_(input) {}

  void change() {
    switch (random_.below(14)) {
      case 0:
        return flip_bit();
      case 1:
        return set_byte();
      case 2:
        return write_integer(kIntegers[random_.below(kIntegers.size())]);
      case 3:
        return nudge_integer();
      case 4:
        return insert(some_bytes());
      case 5:
        return erase();
      case 6:
        return repeat();
      case 7:
        return insert(part_of(any_file()));
      case 8:
        return overwrite(part_of(any_file()));
      case 9:
        return input_.resize(below(input_.size() + 1));
      case 10:
        return write_number();
      default:
        return write_word();
    }
  }

  void cross() {
    const Bytes& other = any_file();
    input_.resize(below(input_.size() + 1));
    input_.insert(input_.end(), other.begin() + offset(below(other.size() + 1)), other.end());
  }

 private:
  static std::ptrdiff_t offset(std::size_t at) { return static_cast<std::ptrdiff_t>(at); }
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(random_.below(n)); }
  const Bytes& any_file() { return files_[below(files_.size())]; }

  // Short ranges most of the time: tokens, fields.
  std::pair<std::size_t, std::size_t> range_in(const Bytes& bytes) {
    const std::size_t begin = below(bytes.size() + 1);
    const std::size_t longest = random_.below(4) == 0 ? bytes.size() : 24;
    return {begin, std::min(bytes.size(), begin + below(longest + 1))};
  }
  Bytes part_of(const Bytes& bytes) {
    const auto [begin, end] = range_in(bytes);
    return {bytes.begin() + offset(begin), bytes.begin() + offset(end)};
  }
  Bytes some_bytes() {
    const Bytes& like = any_file();  // bytes that mean something to the parser, half of the time
    const bool known = !like.empty() && random_.below(2) == 0;
    Bytes bytes(1 + below(8));
    for (std::uint8_t& byte : bytes) {
      byte = known ? like[below(like.size())] : static_cast<std::uint8_t>(random_.next());
    }
    return bytes;
  }

  void flip_bit() {
    if (!input_.empty()) {
      input_[below(input_.size())] ^= static_cast<std::uint8_t>(1U << random_.below(8));
    }
  }
  void set_byte() {
    if (!input_.empty()) {
      input_[below(input_.size())] = static_cast<std::uint8_t>(random_.next());
    }
  }
  void insert(const Bytes& bytes) {
    input_.insert(input_.begin() + offset(below(input_.size() + 1)), bytes.begin(), bytes.end());
  }
  void overwrite(const Bytes& bytes) {
    const std::size_t at = below(input_.size() + 1);
    std::copy_n(bytes.begin(), std::min(bytes.size(), input_.size() - at), input_.begin() + offset(at));
  }
  void erase() {
    const auto [begin, end] = range_in(input_);
    input_.erase(input_.begin() + offset(begin), input_.begin() + offset(end));
  }
  void repeat() {
    const Bytes part = part_of(input_);
    const std::size_t at = below(input_.size() + 1);
    for (std::size_t left = std::size_t{1} << random_.below(8); left > 0 && input_.size() < kMaxInput; --left) {
      input_.insert(input_.begin() + offset(at), part.begin(), part.end());
    }
  }

  // Little-endian, 1, 2, 4 or 8 bytes wide.
  void write_integer(std::uint64_t value) {
    const std::size_t width = std::size_t{1} << random_.below(4);
    if (input_.size() >= width) {
      std::memcpy(input_.data() + below(input_.size() - width + 1), &value, width);
    }
  }
  void nudge_integer() {
    const std::size_t width = std::size_t{1} << random_.below(4);
    if (input_.size() >= width) {
      std::uint8_t* at = input_.data() + below(input_.size() - width + 1);
      std::uint64_t value = 0;
      std::memcpy(&value, at, width);
      value += random_.below(33) - 16;
      std::memcpy(at, &value, width);
    }
  }
  // The first word at or after a random place; empty, at the end, if there is none.
  std::pair<std::size_t, std::size_t> word_in(const Bytes& bytes) {
    const auto begin = std::find_if(bytes.begin() + offset(below(bytes.size() + 1)), bytes.end(), is_word);
    const auto end = std::find_if_not(begin, bytes.end(), is_word);
    return {static_cast<std::size_t>(begin - bytes.begin()), static_cast<std::size_t>(end - bytes.begin())};
  }
  // One word in place of another: what a text is made of, so that it often stays valid.
  void write_word() {
    const Bytes& other = any_file();
    const auto [from, to] = word_in(other);
    const auto [begin, end] = word_in(input_);
    if (from < to && begin < end) {
      const Bytes word(other.begin() + offset(from), other.begin() + offset(to));
      input_.erase(input_.begin() + offset(begin), input_.begin() + offset(end));
      input_.insert(input_.begin() + offset(begin), word.begin(), word.end());
    }
  }
  // In place of a decimal number.
  void write_number() {
    auto begin = std::find_if(input_.begin() + offset(below(input_.size() + 1)), input_.end(), is_digit);
    const auto end = std::find_if_not(begin, input_.end(), is_digit);
    if (begin != end) {
      const std::string_view number = kNumbers[random_.below(kNumbers.size())];
      begin = input_.erase(begin, end);
      input_.insert(begin, number.begin(), number.end());
    }
  }

  const std::vector<Bytes>& files_;
  Xoshiro256& random_;
  Bytes& input_;
};

}  // namespace

Mutation::Mutation(Corpus corpus, std::uint32_t seed)
    : files_(std::move(corpus.good)), good_(files_.size()), seed_(seed) {
  std::move(corpus.bad.begin(), corpus.bad.end(), std::back_inserter(files_));
  COPPICE_CHECK(!files_.empty());
}

void Mutation::make(std::uint32_t i, Bytes& input) const {
  Xoshiro256 random(std::uint64_t{seed_} << 32U | i);
  const bool from_good = good_ > 0 && random.below(4) > 0;
  const Bytes& file = files_[random.below(from_good ? good_ : files_.size())];
  input.assign(file.begin(), file.end());
  Draft draft(files_, random, input);
  if (random.below(8) == 0) {
    draft.cross();
  }
  // 1 to 8 changes, few more often than many: most inputs should get past the first check.
  for (std::uint64_t changes = 1 + random.below(1ULL << random.below(4)); changes > 0; --changes) {
    draft.change();
  }
  if (input.size() > kMaxInput) {
    input.resize(kMaxInput);
  }
}

}  // namespace coppice::fuzz
