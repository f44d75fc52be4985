#include "common/wire/topics.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <memory>
#include <random>
#include <string_view>
#include <unistd.h>

#include "common/check.hpp"
#include "common/host_name.hpp"

namespace coppice::wire {
namespace {

constexpr std::int64_t kNeverBlockMs = 100;  // coordinator: keep-last writers do not block at all
// Anybody may say Hello in a worker's name, or announce a run; what he says must not displace the worker's own, or the
// coordinator's, before it is read.
constexpr std::int32_t kWordsHeard = 16;
constexpr std::int64_t kWorkerBlockMs = 5000;  // worker: an answer waits for room rather than being lost

struct TopicQos {
  const dds_topic_descriptor_t* type;
  std::string name;
  bool transient_local;
  std::int32_t keep_last;  // 0: keep all
  bool liveliness;
  std::int32_t heard;  // of each key, kept by a reader until they are taken; 0: as the writer
};

const TopicQos& qos_of(const dds_topic_descriptor_t& type) {
  static const std::string versioned = fmt::format("coppice_v{}_", kProtocolVersion);
  static const std::array<TopicQos, 7> table = {{
      {&coppice_wire_Hello_desc, "coppice_Hello", true, 1, true, kWordsHeard},
      {&coppice_wire_Control_desc, "coppice_Control", true, 1, true, kWordsHeard},
      {&coppice_wire_Fleet_desc, "coppice_Fleet", false, 1, false, 0},
      {&coppice_wire_Task_desc, versioned + "Task", false, static_cast<std::int32_t>(kTaskDepth), false, 0},
      {&coppice_wire_Answer_desc, versioned + "Answer", false, 0, false, 0},
      {&coppice_wire_ChainRequest_desc, versioned + "ChainRequest", false, 0, false, 0},
      {&coppice_wire_ChainBlock_desc, versioned + "ChainBlock", false, static_cast<std::int32_t>(kBlockDepth), false,
       0},
  }};
  const auto found = std::find_if(table.begin(), table.end(), [&](const TopicQos& row) { return row.type == &type; });
  COPPICE_CHECK(found != table.end());
  return *found;
}

using Qos = std::unique_ptr<dds_qos_t, decltype(&dds_delete_qos)>;

Qos make_qos(const TopicQos& topic, std::int32_t keep_last) {
  Qos qos(dds_create_qos(), &dds_delete_qos);
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_MSECS(keep_last == 0 ? kWorkerBlockMs : kNeverBlockMs));
  dds_qset_durability(qos.get(), topic.transient_local ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  if (keep_last == 0) {
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_ALL, DDS_LENGTH_UNLIMITED);
  } else {
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, keep_last);
  }
  if (topic.liveliness) {
    dds_qset_liveliness(qos.get(), DDS_LIVELINESS_AUTOMATIC, DDS_MSECS(kLivelinessLeaseMs));
  }
  return qos;
}

// Publisher and subscriber exist to carry the partition; they belong to the participant and go with the endpoint.
Result<Entity> make_endpoint(const Participant& participant, const dds_topic_descriptor_t& type,
                             const std::string& partition, bool writes) {
  const TopicQos& topic_qos = qos_of(type);
  const Qos qos = make_qos(topic_qos, !writes && topic_qos.heard > 0 ? topic_qos.heard : topic_qos.keep_last);
  auto topic =
      Entity::own(dds_create_topic(participant.get(), &type, topic_qos.name.c_str(), nullptr, nullptr), topic_qos.name);
  if (!topic) {
    return tl::unexpected(topic.error());
  }
  if (!partition.empty()) {
    // Partition of an implicit publisher or subscriber: taken from the endpoint's QoS.
    const char* names[] = {partition.c_str()};
    dds_qset_partition(qos.get(), 1, names);
  }
  if (writes) {
    dds_qset_writer_data_lifecycle(qos.get(), false);
    return Entity::own(dds_create_writer(participant.get(), topic->get(), qos.get(), nullptr),
                       topic_qos.name + " writer");
  }
  return Entity::own(dds_create_reader(participant.get(), topic->get(), qos.get(), nullptr),
                     topic_qos.name + " reader");
}

}  // namespace

namespace detail {

Result<Entity> make_writer(const Participant& participant, const dds_topic_descriptor_t& type,
                           const std::string& partition) {
  return make_endpoint(participant, type, partition, true);
}

Result<Entity> make_reader(const Participant& participant, const dds_topic_descriptor_t& type,
                           const std::string& partition) {
  return make_endpoint(participant, type, partition, false);
}

}  // namespace detail

std::string partition_of(std::uint64_t worker) { return fmt::format("worker-{:016x}", worker); }

coppice_wire_ChainId to_wire(const ChainHash& hash) {
  coppice_wire_ChainId id{};
  std::copy(hash.bytes.begin(), hash.bytes.end(), std::begin(id.bytes));
  return id;
}

ChainHash from_wire(const coppice_wire_ChainId& id) {
  ChainHash hash;
  std::copy(std::begin(id.bytes), std::end(id.bytes), hash.bytes.begin());
  return hash;
}

WorkerStatus status_of(const Hello& hello) {
  WorkerStatus status{};
  status.protocol = hello.protocol;
  status.worker = hello.worker;
  put_text(status.version, hello.version);
  put_text(status.host, hello.host);
  status.pid = hello.pid;
  status.cores = hello.cores;
  status.threads = hello.threads;
  status.evaluated = hello.evaluated;
  return status;
}

std::uint64_t random_identity() {
  std::random_device device;
  const std::uint64_t high = device();
  return high << 32U | device() | 1U;
}

std::string shown(const char* text) {
  std::string result(text);
  for (char& c : result) {
    if (c < ' ' || c > '~') {
      c = '?';
    }
  }
  return result;
}

std::string host_name() {
  const std::string name = coppice::host_name();
  return name.empty() ? "unknown-host" : name;
}

}  // namespace coppice::wire
