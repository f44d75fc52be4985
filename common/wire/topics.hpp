// The topics of the contract: name and QoS of each, in one place, with typed writers and readers that cannot be
// made with any other. idl/README.md gives the reasons. A writer or reader belongs to the thread that uses it, unless
// said otherwise; take() of one reader by several threads is safe (DDS hands each sample to one of them).
#pragma once

#include <array>
#include <coppice.h>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "common/chain/chain_bytes.hpp"
#include "common/error.hpp"
#include "common/wire/entity.hpp"
#include "common/wire/participant.hpp"

namespace coppice::wire {

// Of every sample. A change of the contract that old programs would misread raises it, and so does a change of what
// evaluate() returns: workers of two builds must never give two answers.
inline constexpr std::uint32_t kProtocolVersion = 5;

using Hello = coppice_wire_Hello;
using Control = coppice_wire_Control;
using Fleet = coppice_wire_Fleet;
using WorkerStatus = coppice_wire_WorkerStatus;
using Task = coppice_wire_Task;
using Answer = coppice_wire_Answer;
using ChainRequest = coppice_wire_ChainRequest;
using ChainBlock = coppice_wire_ChainBlock;

// How long a worker's (or coordinator's) Hello (or Control) may go unrenewed by DDS before it counts as gone.
inline constexpr std::int64_t kLivelinessLeaseMs = 1500;
inline constexpr std::uint32_t kTaskDepth = 64;    // samples kept per worker: far above the credit
inline constexpr std::uint32_t kBlockDepth = 32;   // chain blocks kept per worker
inline constexpr std::uint32_t kBlockWindow = 16;  // chain blocks that a worker asks for at once
inline constexpr std::size_t kMaxTaskPayload = coppice_wire_MAX_PAYLOAD;
inline constexpr std::size_t kBlockBytes = coppice_wire_MAX_BLOCK;

// The partition in which a worker gets its tasks and blocks.
std::string partition_of(std::uint64_t worker);

namespace detail {
Result<Entity> make_writer(const Participant&, const dds_topic_descriptor_t&, const std::string& partition);
Result<Entity> make_reader(const Participant&, const dds_topic_descriptor_t&, const std::string& partition);
template <typename Sample>
const dds_topic_descriptor_t& descriptor();
template <>
inline const dds_topic_descriptor_t& descriptor<Hello>() {
  return coppice_wire_Hello_desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<Control>() {
  return coppice_wire_Control_desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<Fleet>() {
  return coppice_wire_Fleet_desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<Task>() {
  return coppice_wire_Task_desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<Answer>() {
  return coppice_wire_Answer_desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<ChainRequest>() {
  return coppice_wire_ChainRequest_desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<ChainBlock>() {
  return coppice_wire_ChainBlock_desc;
}
}  // namespace detail

template <typename Sample>
class Writer {
 public:
  // `partition`: empty for the default one.
  static Result<Writer> make(const Participant& participant, const std::string& partition = {}) {
    return detail::make_writer(participant, detail::descriptor<Sample>(), partition).map([](Entity&& entity) {
      return Writer(std::move(entity));
    });
  }
  // Errors: what DDS said (a timeout when a reader does not keep up, a bound that is exceeded).
  Result<void> write(const Sample& sample) {
    if (const dds_return_t code = dds_write(entity_.get(), &sample); code != DDS_RETCODE_OK) {
      return failed(std::string("DDS write: ") + dds_strretcode(-code));
    }
    return {};
  }
  // Whether a reader is there. Also clears the status that wakes a Waiter.
  bool matched() const {
    dds_publication_matched_status_t status{};
    return dds_get_publication_matched_status(entity_.get(), &status) == DDS_RETCODE_OK && status.current_count > 0;
  }
  bool wait_for_acknowledgements(std::int64_t milliseconds) const {
    return dds_wait_for_acks(entity_.get(), DDS_MSECS(milliseconds)) == DDS_RETCODE_OK;
  }
  dds_entity_t get() const { return entity_.get(); }

 private:
  explicit Writer(Entity entity) : entity_(std::move(entity)) {}
  Entity entity_;
};

template <typename Sample>
class Reader {
 public:
  static Result<Reader> make(const Participant& participant, const std::string& partition = {}) {
    return detail::make_reader(participant, detail::descriptor<Sample>(), partition).map([](Entity&& entity) {
      return Reader(std::move(entity));
    });
  }
  // Hands at most `most` samples to on_sample(const Sample&, const dds_sample_info_t&); returns how many there were.
  // When !info.valid_data only the key is set. The sample is on loan: it is gone when on_sample returns.
  template <typename OnSample>
  std::size_t take(std::size_t most, const OnSample& on_sample) const {
    constexpr std::size_t kChunk = 16;
    std::size_t taken = 0;
    while (taken < most) {
      std::array<void*, kChunk> samples{};
      std::array<dds_sample_info_t, kChunk> infos;
      const std::size_t wanted = most - taken < kChunk ? most - taken : kChunk;
      const dds_return_t count =
          dds_take(entity_.get(), samples.data(), infos.data(), wanted, static_cast<std::uint32_t>(wanted));
      if (count <= 0) {
        break;
      }
      const Loan loan{entity_.get(), samples.data(), count};
      for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
        on_sample(*static_cast<const Sample*>(samples[i]), infos[i]);
      }
      taken += static_cast<std::size_t>(count);
    }
    return taken;
  }
  dds_entity_t get() const { return entity_.get(); }

 private:
  // Given back also when on_sample throws.
  struct Loan {
    dds_entity_t reader;
    void** samples;
    std::int32_t count;
    ~Loan() { dds_return_loan(reader, samples, count); }
  };

  explicit Reader(Entity entity) : entity_(std::move(entity)) {}
  Entity entity_;
};

// A payload lent to DDS for one write; the bytes must outlive the call.
inline dds_sequence_octet lend(std::span<const std::uint8_t> bytes) {
  dds_sequence_octet sequence;
  sequence._maximum = static_cast<std::uint32_t>(bytes.size());
  sequence._length = static_cast<std::uint32_t>(bytes.size());
  sequence._buffer = const_cast<std::uint8_t*>(bytes.data());  // DDS only reads it
  sequence._release = false;
  return sequence;
}
inline std::span<const std::uint8_t> view(const dds_sequence_octet& sequence) {
  return {sequence._buffer, sequence._length};
}

// What a Hello says of its worker; what it does is not filled in.
WorkerStatus status_of(const Hello& hello);

coppice_wire_ChainId to_wire(const ChainHash& hash);
ChainHash from_wire(const coppice_wire_ChainId& id);

// Copies a text into a sample's field, cut to its bound.
template <std::size_t N>
void put_text(char (&field)[N], std::string_view text) {
  const std::size_t length = text.size() < N - 1 ? text.size() : N - 1;
  text.copy(field, length);
  field[length] = '\0';
}
// A text from a stranger, fit for a terminal: control and non-ASCII characters become '?'.
std::string shown(const char* text);

// A number that no other process draws, for workers and runs; never 0.
std::uint64_t random_identity();

// "host" of this machine, for Hello and Control.
std::string host_name();

}  // namespace coppice::wire
