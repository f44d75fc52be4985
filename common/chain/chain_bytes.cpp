#include "common/chain/chain_bytes.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <memory>
#include <xxhash.h>

#include "common/chain/bytes.hpp"

namespace coppice {
namespace {

constexpr std::array<char, 4> kMagic = {'C', 'P', 'C', 'H'};
constexpr std::uint32_t kPlainFormat = 1;
constexpr std::uint32_t kFullFormat = 2;
constexpr std::uint8_t kAdmitsEqual = 1;
constexpr std::uint8_t kAdmitsLessEqual = 2;

bool is_plain(const ChainParts& parts) {
  const auto plain = [](const Feature& feature) { return feature.scale == Scale::plain; };
  return std::all_of(parts.vocabulary.features.begin(), parts.vocabulary.features.end(), plain) &&
         parts.starts.empty() && parts.no_action == NoAction{} && !parts.look_alikes && parts.terminals.empty() &&
         parts.forbidden.empty() && parts.collisions.empty();
}

void put_vocabulary(const Vocabulary& vocabulary, bool plain, ByteWriter& writer) {
  writer.put(static_cast<std::uint16_t>(vocabulary.features.size()));
  for (const Feature& feature : vocabulary.features) {
    writer.put_text(feature.name);
    writer.put(static_cast<std::uint8_t>((feature.admits_equal ? kAdmitsEqual : 0) |
                                         (feature.admits_less_equal ? kAdmitsLessEqual : 0)));
    writer.put(static_cast<std::uint16_t>(feature.values.size()));
    writer.put_all(feature.values);
    if (!plain) {
      writer.put(static_cast<std::uint8_t>(feature.scale));
      writer.put(static_cast<std::uint16_t>(feature.numbers.size()));
      writer.put_all(feature.numbers);
    }
  }
  writer.put(static_cast<std::uint16_t>(vocabulary.actions.size()));
  for (const std::string& action : vocabulary.actions) {
    writer.put_text(action);
  }
}

Result<Vocabulary> get_vocabulary(bool plain, ByteReader& reader) {
  Vocabulary vocabulary;
  const auto features = reader.get<std::uint16_t>();
  if (features > kMaxFeatures) {
    return bad_input(fmt::format("chain has {} features: expected at most {}", features, kMaxFeatures));
  }
  for (std::uint16_t i = 0; i < features; ++i) {
    Feature feature;
    feature.name = reader.get_text();
    const auto operators = reader.get<std::uint8_t>();
    if (operators > (kAdmitsEqual | kAdmitsLessEqual)) {
      return bad_input(fmt::format("feature {} has operators {}: expected 0 to 3", i, operators));
    }
    feature.admits_equal = (operators & kAdmitsEqual) != 0;
    feature.admits_less_equal = (operators & kAdmitsLessEqual) != 0;
    feature.values = reader.get_all<std::uint8_t>(reader.get<std::uint16_t>());
    if (!plain) {
      const auto scale = reader.get<std::uint8_t>();
      if (scale > static_cast<std::uint8_t>(Scale::bins)) {
        return bad_input(fmt::format("feature {} has scale {}: expected 0 to 2", i, scale));
      }
      feature.scale = static_cast<Scale>(scale);
      feature.numbers = reader.get_all<double>(reader.get<std::uint16_t>());
    }
    vocabulary.features.push_back(std::move(feature));
  }
  const auto actions = reader.get<std::uint16_t>();
  if (actions > kMaxActions) {
    return bad_input(fmt::format("chain has {} actions: expected at most {}", actions, kMaxActions));
  }
  for (std::uint16_t i = 0; i < actions; ++i) {
    vocabulary.actions.push_back(reader.get_text());
  }
  return vocabulary;
}

void put_episodes(const ChainParts& parts, ByteWriter& writer) {
  writer.put(static_cast<std::uint32_t>(parts.starts.size()));
  for (const StartShare& start : parts.starts) {
    writer.put(start.state);
    writer.put(start.count);
  }
  writer.put(static_cast<std::uint8_t>(parts.no_action.kind));
  writer.put(static_cast<std::uint8_t>(parts.no_action.action));
  writer.put(static_cast<std::uint8_t>(parts.look_alikes ? 1 : 0));
  writer.put(static_cast<std::uint32_t>(parts.terminals.size()));
  writer.put_all(parts.terminals);
  writer.put(static_cast<std::uint8_t>(parts.forbidden.empty() ? 0 : 1));
  writer.put(static_cast<std::uint8_t>(parts.collisions.empty() ? 0 : 1));
}

struct RowArrays {
  bool forbidden = false;
  bool collisions = false;
};

Result<RowArrays> get_episodes(ByteReader& reader, ChainParts& parts) {
  const std::size_t starts = reader.get<std::uint32_t>();
  parts.starts.reserve(std::min(starts, reader.left() / 8));
  for (std::size_t i = 0; i < starts && reader.ok(); ++i) {
    const auto state = reader.get<std::uint32_t>();
    parts.starts.push_back({state, reader.get<std::uint32_t>()});
  }
  const auto kind = reader.get<std::uint8_t>();
  parts.no_action.action = ActionId{reader.get<std::uint8_t>()};
  const auto look_alikes = reader.get<std::uint8_t>();
  parts.terminals = reader.get_all<std::uint32_t>(reader.get<std::uint32_t>());
  const auto forbidden = reader.get<std::uint8_t>();
  const auto collisions = reader.get<std::uint8_t>();
  if (kind > static_cast<std::uint8_t>(NoAction::Kind::named)) {
    return bad_input(fmt::format("chain has no-action rule {}: expected 0 to 2", kind));
  }
  if (look_alikes > 1 || forbidden > 1 || collisions > 1) {
    return bad_input(fmt::format("chain has flags {}, {}, {}: expected 0 or 1", look_alikes, forbidden, collisions));
  }
  parts.no_action.kind = static_cast<NoAction::Kind>(kind);
  parts.look_alikes = look_alikes != 0;
  return RowArrays{forbidden != 0, collisions != 0};
}

ChainHash canonical(const XXH128_hash_t& value) {
  XXH128_canonical_t digits;
  XXH128_canonicalFromHash(&digits, value);
  ChainHash hash;
  std::copy(std::begin(digits.digest), std::end(digits.digest), hash.bytes.begin());
  return hash;
}

Result<Chain> get_chain(ByteReader reader) {
  const std::size_t size = reader.left();
  if (reader.get<std::array<char, 4>>() != kMagic) {
    return bad_input("not a chain: expected it to begin with 'CPCH'");
  }
  const auto format = reader.get<std::uint32_t>();
  if (format != kPlainFormat && format != kFullFormat) {
    return bad_input(fmt::format("chain has format {}: expected {} or {}", format, kPlainFormat, kFullFormat));
  }
  const bool plain = format == kPlainFormat;
  auto vocabulary = get_vocabulary(plain, reader);
  if (!vocabulary) {
    return tl::unexpected(vocabulary.error());
  }
  ChainParts parts;
  parts.vocabulary = std::move(*vocabulary);
  const auto states = reader.get<std::uint64_t>();
  const auto transitions = reader.get<std::uint64_t>();
  parts.initial_state = reader.get<std::uint32_t>();
  if (states > kMaxStates || transitions > kMaxTransitions) {
    return bad_input(fmt::format("chain has {} states and {} transitions: expected at most {} and {}", states,
                                 transitions, kMaxStates, kMaxTransitions));
  }
  RowArrays more;
  if (!plain) {
    const auto read = get_episodes(reader, parts);
    if (!read) {
      return tl::unexpected(read.error());
    }
    more = *read;
  }
  const std::size_t rows = states * parts.vocabulary.actions.size();
  parts.features = reader.get_all<std::uint8_t>(states * parts.vocabulary.features.size());
  parts.row_begin = reader.get_all<std::uint64_t>(rows + 1);
  parts.successor = reader.get_all<std::uint32_t>(transitions);
  parts.count = reader.get_all<std::uint32_t>(transitions);
  parts.reward_sum = reader.get_all<double>(rows);
  parts.q = reader.get_all<double>(rows);
  parts.policy = reader.get_all<ActionId>(states);
  parts.visits = reader.get_all<std::uint64_t>(states);
  parts.forbidden = reader.get_all<std::uint8_t>(more.forbidden ? rows : 0);
  parts.collisions = reader.get_all<std::uint32_t>(more.collisions ? rows : 0);
  if (!reader.ok()) {
    return bad_input(fmt::format("chain is cut short: {} bytes do not hold {} states and {} transitions", size, states,
                                 transitions));
  }
  if (reader.left() != 0) {
    return bad_input(fmt::format("chain is followed by {} foreign bytes", reader.left()));
  }
  if (is_plain(parts) != plain || (more.forbidden && parts.forbidden.empty()) ||
      (more.collisions && parts.collisions.empty())) {
    return bad_input(fmt::format("chain has format {}, which is not that of what it holds", format));
  }
  return Chain::make(std::move(parts));
}

}  // namespace

std::vector<std::uint8_t> to_bytes(const Chain& chain) {
  const ChainParts& parts = chain.parts();
  ByteWriter writer;
  writer.reserve(4096 + parts.features.size() + parts.row_begin.size() * 8 + parts.successor.size() * 8 +
                 parts.q.size() * 16 + parts.visits.size() * 9 + parts.starts.size() * 8 + parts.terminals.size() * 4 +
                 parts.forbidden.size() + parts.collisions.size() * 4);
  writer.put(kMagic);
  const bool plain = is_plain(parts);
  writer.put(plain ? kPlainFormat : kFullFormat);
  put_vocabulary(parts.vocabulary, plain, writer);
  writer.put(static_cast<std::uint64_t>(chain.states()));
  writer.put(static_cast<std::uint64_t>(chain.transitions()));
  writer.put(parts.initial_state);
  if (!plain) {
    put_episodes(parts, writer);
  }
  writer.put_all(parts.features);
  writer.put_all(parts.row_begin);
  writer.put_all(parts.successor);
  writer.put_all(parts.count);
  writer.put_all(parts.reward_sum);
  writer.put_all(parts.q);
  writer.put_all(parts.policy);
  writer.put_all(parts.visits);
  writer.put_all(parts.forbidden);
  writer.put_all(parts.collisions);
  return writer.take();
}

Result<Chain> chain_from_bytes(std::span<const std::uint8_t> bytes) { return get_chain(ByteReader(bytes)); }

Result<Chain> chain_from_pieces(std::vector<std::vector<std::uint8_t>> pieces) {
  std::size_t size = 0;
  for (const auto& piece : pieces) {
    size += piece.size();
  }
  std::size_t read = 0;
  return get_chain(ByteReader(size, [&pieces, &read]() -> std::span<const std::uint8_t> {
    if (read > 0) {
      pieces[read - 1] = std::vector<std::uint8_t>();
    }
    return pieces[read++];
  }));
}

std::string ChainHash::hex() const { return fmt::format("{:02x}", fmt::join(bytes, "")); }

ChainHash hash_of(std::span<const std::uint8_t> bytes) { return canonical(XXH3_128bits(bytes.data(), bytes.size())); }

ChainHash hash_of(const std::vector<std::vector<std::uint8_t>>& pieces) {
  const std::unique_ptr<XXH3_state_t, void (*)(XXH3_state_t*)> state(XXH3_createState(),
                                                                     [](XXH3_state_t* made) { XXH3_freeState(made); });
  XXH3_128bits_reset(state.get());
  for (const auto& piece : pieces) {
    XXH3_128bits_update(state.get(), piece.data(), piece.size());
  }
  return canonical(XXH3_128bits_digest(state.get()));
}

Result<ChainHash> chain_hash_from_hex(std::string_view hex) {
  const auto digit = [](char c) -> int {
    if (c >= '0' && c <= '9') {
      return c - '0';
    }
    return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
  };
  ChainHash hash;
  if (hex.size() != 2 * hash.bytes.size() ||
      std::any_of(hex.begin(), hex.end(), [&](char c) { return digit(c) < 0; })) {
    return bad_input("a chain hash is 32 hexadecimal digits");
  }
  for (std::size_t i = 0; i < hash.bytes.size(); ++i) {
    hash.bytes[i] = static_cast<std::uint8_t>(digit(hex[2 * i]) * 16 + digit(hex[2 * i + 1]));
  }
  return hash;
}

}  // namespace coppice
