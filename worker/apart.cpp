#include "worker/apart.hpp"

#include <array>
#include <cerrno>
#include <cstring>
#include <fmt/format.h>
#include <span>
#include <unistd.h>
#include <vector>

#include "common/chain/bytes.hpp"
#include "common/chain/chain_bytes.hpp"
#include "common/fitness/evaluation.hpp"
#include "common/fitness/prepared_chain.hpp"
#include "common/wire/codec.hpp"
#include "worker/chain_store.hpp"
#include "worker/epochs.hpp"

namespace coppice {
namespace {

constexpr std::size_t kMostTask = std::size_t{64} * 1024 * 1024;

Result<std::vector<std::uint8_t>> read_all() {
  std::vector<std::uint8_t> bytes;
  std::array<std::uint8_t, 65536> some;
  while (bytes.size() <= Assembly::kMaxChainBytes + kMostTask) {
    const ssize_t count = read(STDIN_FILENO, some.data(), some.size());
    if (count == 0) {
      return bytes;
    }
    if (count < 0 && errno != EINTR) {
      return failed(fmt::format("standard input: {}", std::strerror(errno)));
    }
    bytes.insert(bytes.end(), some.begin(), some.begin() + std::max<ssize_t>(count, 0));
  }
  return bad_input("standard input: more bytes than a chain and a task have");
}

Result<void> write_all(std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = write(STDOUT_FILENO, bytes.data(), bytes.size());
    if (count < 0 && errno != EINTR) {
      return failed(fmt::format("standard output: {}", std::strerror(errno)));
    }
    bytes = bytes.subspan(count < 0 ? 0 : static_cast<std::size_t>(count));
  }
  return {};
}

}  // namespace

namespace {

Result<std::vector<std::uint8_t>> evaluate(const std::shared_ptr<const PreparedChain>& chain,
                                           std::span<const std::uint8_t> payload) {
  wire::TaskDecoder decoder(chain->chain().vocabulary());
  const auto task = decoder.decode(payload);
  if (!task) {
    return tl::unexpected(task.error());
  }
  auto job = PreparedJob::make(chain, task->job, nullptr);
  if (!job) {
    return tl::unexpected(job.error());
  }
  Evaluation evaluation(std::move(*job));
  std::vector<Tally> tallies;
  for (std::size_t done = 0; done < task->trees.size();) {
    const std::size_t count = std::min<std::size_t>(evaluation.trees_per_pass(), task->trees.size() - done);
    auto some = evaluation.evaluate(std::span(task->trees).subspan(done, count));
    std::move(some.begin(), some.end(), std::back_inserter(tallies));
    done += count;
  }
  return wire::encode_tallies(tallies);
}

}  // namespace

Result<void> evaluate_apart() {
  const auto input = read_all();
  if (!input) {
    return tl::unexpected(input.error());
  }
  ByteReader reader(*input);
  const auto epoch = reader.get<std::uint8_t>();
  const auto length = reader.get<std::uint64_t>();
  constexpr std::size_t kHead = sizeof epoch + sizeof length;
  if (!reader.ok() || epoch > 1 || reader.left() < length) {
    return bad_input(fmt::format("standard input: {} bytes hold no chain of {}", input->size(), length));
  }
  const std::span<const std::uint8_t> all(*input);
  auto chain = chain_from_bytes(all.subspan(kHead, length));
  if (!chain) {
    return tl::unexpected(chain.error());
  }
  const auto prepared = PreparedChain::make(std::make_shared<const Chain>(std::move(*chain)));
  const auto payload = all.subspan(kHead + length);
  const auto answer =
      epoch == 1 ? Epochs(prepared).run(payload, [](std::size_t) { return true; }) : evaluate(prepared, payload);
  return answer ? write_all(*answer) : tl::unexpected(answer.error());
}

}  // namespace coppice
