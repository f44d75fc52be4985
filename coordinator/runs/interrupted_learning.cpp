#include "coordinator/runs/interrupted_learning.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <limits>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "common/chain/bytes.hpp"
#include "common/chain/chain_bytes.hpp"
#include "coordinator/console/whole_file.hpp"

namespace coppice {
namespace {

constexpr std::uint64_t kMark = 0x6E7261656C706F63;  // "coplearn"
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kMostText = std::numeric_limits<std::uint16_t>::max();

// A room of the largest size does not fit what put_text() can say.
void put_long_text(ByteWriter& writer, std::string_view text) {
  writer.put(static_cast<std::uint32_t>(text.size()));
  writer.put_all(std::vector<char>(text.begin(), text.end()));
}

std::string get_long_text(ByteReader& reader) {
  const std::vector<char> text = reader.get_all<char>(reader.get<std::uint32_t>());
  return {text.begin(), text.end()};
}

void put_settings(ByteWriter& writer, const LearnSettings& settings) {
  writer.put(settings.algorithm);
  writer.put(settings.decay);
  writer.put(settings.steps);
  writer.put(settings.episodes);
  writer.put(settings.greedy_episodes);
  writer.put(settings.seed);
  writer.put(settings.alpha);
  writer.put(settings.gamma);
  writer.put(settings.epsilon);
}

// As the bytes have it, not checked: learn() calls check_settings().
LearnSettings get_settings(ByteReader& reader) {
  LearnSettings settings;
  settings.algorithm = reader.get<std::uint8_t>() == 1 ? Algorithm::sarsa : Algorithm::q_learning;
  settings.decay = static_cast<Decay>(std::min<std::uint8_t>(reader.get<std::uint8_t>(), 2));
  settings.steps = reader.get<std::uint32_t>();
  settings.episodes = reader.get<std::uint64_t>();
  settings.greedy_episodes = reader.get<std::uint64_t>();
  settings.seed = reader.get<std::uint64_t>();
  settings.alpha = reader.get<double>();
  settings.gamma = reader.get<double>();
  settings.epsilon = reader.get<double>();
  return settings;
}

Result<std::vector<std::uint8_t>> bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    return bad_input(fmt::format("{}: cannot open: expected learning that was interrupted", path.string()));
  }
  std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (file.bad()) {
    return bad_input(fmt::format("{}: cannot be read", path.string()));
  }
  return bytes;
}

}  // namespace

std::filesystem::path interrupted_learning_path(const std::string& study) { return study + ".learning"; }

Result<void> write_interrupted_learning(const std::filesystem::path& path, const InterruptedLearning& learning) {
  ByteWriter writer;
  writer.put(kMark);
  writer.put(kVersion);
  writer.put_text(std::string_view(learning.task.world_name).substr(0, kMostText));
  writer.put_text(name_of(learning.task.world.kind));
  put_long_text(writer, learning.task.world.room);
  put_settings(writer, learning.task.settings);
  writer.put(learning.checkpoint.episodes_done);
  writer.put(static_cast<std::uint64_t>(learning.checkpoint.state.size()));
  writer.put_all(learning.checkpoint.state);
  writer.put(hash_of(writer.bytes()));
  const std::vector<std::uint8_t> bytes = writer.take();
  return write_whole_file(path, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

Result<InterruptedLearning> read_interrupted_learning(const std::filesystem::path& path) {
  const Result<std::vector<std::uint8_t>> bytes = bytes_of(path);
  if (!bytes) {
    return tl::unexpected(bytes.error());
  }
  const auto wrong = [&](std::string_view what) { return bad_input(fmt::format("{}: {}", path.string(), what)); };
  ByteReader reader(*bytes);
  if (reader.get<std::uint64_t>() != kMark) {
    return wrong("no interrupted learning: expected a file that 'coppice learn' wrote");
  }
  if (const auto version = reader.get<std::uint32_t>(); version != kVersion) {
    return wrong(fmt::format("version {}: expected {}", version, kVersion));
  }
  std::string world_name = reader.get_text();
  const std::string kind = reader.get_text();
  const std::string room = get_long_text(reader);
  const LearnSettings settings = get_settings(reader);
  LearnCheckpoint checkpoint;
  checkpoint.episodes_done = reader.get<std::uint64_t>();
  checkpoint.state = reader.get_all<std::uint8_t>(reader.get<std::uint64_t>());
  const auto hash = reader.get<ChainHash>();
  if (!reader.ok() || reader.left() != 0 || checkpoint.state.empty() ||
      hash != hash_of(std::span(*bytes).first(bytes->size() - sizeof(ChainHash)))) {
    return wrong("is damaged: its hash does not fit what it holds");
  }
  Result<World> world = make_world(kind, room);
  if (!world) {
    return in_context(path.string(), world.error());
  }
  return InterruptedLearning{{std::move(world_name), std::move(*world), settings}, std::move(checkpoint)};
}

}  // namespace coppice
