// Datagrams that are no business of whoever gets them, for the tests: random bytes; RTPS messages that are made up of
// true submessages with wild values; and packets that were heard, changed here and there. Each comes from a seed.
#pragma once

#include <array>
#include <cstdint>
#include <random>
#include <string>
#include <string_view>
#include <vector>

namespace coppice::e2e {

class Datagrams {
 public:
  explicit Datagrams(std::uint32_t seed);

  // A true packet, to be changed and sent back.
  void learn(std::string_view packet);
  std::size_t learnt() const { return heard_.size(); }

  std::string next();

  // What a participant says that is here (SPDP): those who believe it answer to this IPv4 address and port.
  std::string announcement(std::uint32_t address, std::uint16_t port) const;

 private:
  using Prefix = std::array<char, 12>;

  std::uint32_t below(std::uint32_t limit) { return static_cast<std::uint32_t>(random_() % limit); }
  std::uint32_t wild();
  std::uint32_t entity();
  std::string noise(std::size_t size);
  std::string submessage();
  std::string parameters();
  std::string made_up();
  std::string changed(std::string packet);

  std::mt19937 random_;
  Prefix own_{};
  std::vector<std::string> heard_;
  std::vector<Prefix> prefixes_;  // of those who were heard
};

}  // namespace coppice::e2e
