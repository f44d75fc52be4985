// A program that speaks the wire contract badly, on purpose, for the tests:
//   stranger DOMAIN noise   writes damaged and foreign samples of every kind that a worker may write, then leaves
//   stranger DOMAIN next    a worker of the next protocol version
//   stranger DOMAIN build   a worker of another build, which computes otherwise
//   stranger DOMAIN knock   says that it is a worker and answers batches that it was never given, for 3 s; prints how
//                           many samples it heard
//   stranger DOMAIN forge   answers, and takes its leave, in the name of every worker that the coordinator
//                           shows, for 3 s; prints in how many names
//   stranger DOMAIN dispose, unregister, vanish or steal   for 2 s, again and again, to every worker that the
//   coordinator
//                           shows: disposes of its Hello; unregisters it with a writer that disposes then; takes its
//                           leave by a writer that is deleted at once, so that nobody can be asked whose it was;
//                           disposes of it and says Hello in its name. Prints to how many names
//   stranger DOMAIN rule    tries to write what only a coordinator may write; prints what it was allowed
//   stranger DOMAIN mislead IDENTITY PORT         to the worker at that port, for 2 s: announces runs of another
//   version and of another build, and disposes of what is announced. Fails unless the worker's reader got it stranger
//   DOMAIN usurp IDENTITY RULES PORT     plays the coordinator (usurp.hpp)
// It goes to the coordinator on this machine, or on COPPICE_STRANGER_HOST. A third argument is the folder of an
// identity under DDS Security; - is none.
#include <cstdio>
#include <cstdlib>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "common/stop.hpp"
#include "common/wire/configuration.hpp"
#include "common/wire/topics.hpp"
#include "common/wire/waiter.hpp"
#include "tests/e2e/usurp.hpp"
#include "worker/serve.hpp"

namespace {

using namespace coppice;

constexpr int kMostWaits = 600;  // of 100 ms, for the coordinator
constexpr std::int64_t kAcknowledgeMs = 10'000;
constexpr std::chrono::seconds kKnockingTime{3};

int fail(const std::string& what) {
  std::fprintf(stderr, "stranger: %s\n", what.c_str());
  return 1;
}

template <typename T>
T required(Result<T> result) {
  if (!result) {
    std::exit(fail(result.error().message));
  }
  return std::move(*result);
}

void write_answers(wire::Writer<wire::Answer>& answers, const wire::Control& control) {
  const std::vector<std::uint8_t> garbage(100, 0xAB);
  for (std::uint64_t batch = 0; batch < 200; ++batch) {
    wire::Answer answer{};
    answer.protocol = batch % 3 == 0 ? control.protocol + 1 : control.protocol;
    answer.run_id = batch % 5 == 0 ? 1 : control.run_id;
    answer.chain = control.chain;
    answer.chain.bytes[0] = static_cast<std::uint8_t>(answer.chain.bytes[0] + (batch % 7 == 0 ? 1 : 0));
    answer.worker = batch;
    answer.batch = batch;
    answer.outcome = static_cast<coppice_wire_Outcome>(batch % 4);
    answer.elapsed_ns = ~std::uint64_t{0};
    answer.payload = wire::lend(garbage);
    if (auto ok = answers.write(answer); !ok) {
      std::exit(fail(ok.error().message));
    }
  }
}

void write_requests(wire::Writer<wire::ChainRequest>& requests, const wire::Control& control) {
  for (std::uint32_t i = 0; i < 100; ++i) {
    wire::ChainRequest request{};
    request.protocol = control.protocol;
    request.run_id = i % 2 == 0 ? control.run_id : 7;
    request.chain = control.chain;
    request.worker = 0xBAD;
    request.first = i % 3 == 0 ? 0xFFFFFFF0U : i;
    request.count = 0xFFFFFFFFU;
    if (auto ok = requests.write(request); !ok) {
      std::exit(fail(ok.error().message));
    }
  }
}

// A worker in name: says that it holds the chain, takes batches and answers each with garbage.
void write_hello(wire::Writer<wire::Hello>& hellos, const wire::Control& control) {
  wire::Hello hello{};
  hello.protocol = control.protocol;
  hello.worker = 0xBAD;
  hello.golden = control.golden;
  hello.run_id = control.run_id;
  wire::put_text(hello.host, "\x1b[31mevil\x07");
  hello.threads = 0;
  coppice_wire_ChainId chain = control.chain;
  hello.chains = {1, 1, &chain, false};
  if (auto ok = hellos.write(hello); !ok) {
    std::exit(fail(ok.error().message));
  }
}

wire::Participant join(std::uint32_t domain, const wire::Network& network) {
  const char* host = std::getenv("COPPICE_STRANGER_HOST");
  return required(wire::Participant::join(
      domain, required(wire::worker_configuration(host == nullptr ? "127.0.0.1" : host, domain, network))));
}

int make_noise(std::uint32_t domain, const wire::Network& network) {
  const auto participant = join(domain, network);
  const auto controls = required(wire::Reader<wire::Control>::make(participant));
  const auto tasks = required(wire::Reader<wire::Task>::make(participant, wire::partition_of(0xBAD)));
  auto waiter = required(wire::Waiter::make(participant));
  if (!waiter.watch_reader(controls.get()) || !waiter.watch_reader(tasks.get())) {
    return fail("cannot wait");
  }
  auto hellos = required(wire::Writer<wire::Hello>::make(participant));
  auto answers = required(wire::Writer<wire::Answer>::make(participant));
  auto requests = required(wire::Writer<wire::ChainRequest>::make(participant));
  wire::Control control{};
  bool met = false;
  for (int i = 0; i < kMostWaits && !met; ++i) {
    waiter.wait(std::chrono::milliseconds(100));
    controls.take(16, [&](const wire::Control& sample, const dds_sample_info_t& info) {
      control = info.valid_data ? sample : control;
      met = met || info.valid_data;
    });
  }
  if (!met) {
    return fail("no coordinator");
  }
  write_hello(hellos, control);
  write_answers(answers, control);
  write_requests(requests, control);
  // Until a batch comes: it is answered with bytes that are no tallies.
  bool answered = false;
  for (int i = 0; i < kMostWaits && !answered; ++i) {
    controls.take(16, [](const wire::Control&, const dds_sample_info_t&) {});  // else it goes on waking the waiter
    tasks.take(16, [&](const wire::Task& task, const dds_sample_info_t& info) {
      if (info.valid_data) {
        wire::Answer answer{};
        answer.protocol = task.protocol;
        answer.run_id = task.run_id;
        answer.chain = task.chain;
        answer.worker = 0xBAD;
        answer.batch = task.batch;
        answer.outcome = coppice_wire_EVALUATED;
        answered = answers.write(answer).has_value() || answered;
      }
    });
    if (!answered) {
      waiter.wait(std::chrono::milliseconds(100));
    }
  }
  if (!answered) {
    return fail("got no batch");
  }
  answers.wait_for_acknowledgements(kAcknowledgeMs);
  requests.wait_for_acknowledgements(kAcknowledgeMs);
  std::puts("done");
  return 0;
}

int knock(std::uint32_t domain, const wire::Network& network) {
  const auto participant = join(domain, network);
  const auto controls = required(wire::Reader<wire::Control>::make(participant));
  const auto tasks = required(wire::Reader<wire::Task>::make(participant, wire::partition_of(0xBAD)));
  auto waiter = required(wire::Waiter::make(participant));
  auto hellos = required(wire::Writer<wire::Hello>::make(participant));
  auto answers = required(wire::Writer<wire::Answer>::make(participant));
  wire::Control guessed{};
  guessed.protocol = wire::kProtocolVersion;
  guessed.run_id = 1;
  std::size_t heard = 0;
  const auto end = std::chrono::steady_clock::now() + kKnockingTime;
  while (std::chrono::steady_clock::now() < end) {
    write_hello(hellos, guessed);
    write_answers(answers, guessed);
    waiter.wait(std::chrono::milliseconds(100));
    heard += controls.take(16, [](const wire::Control&, const dds_sample_info_t&) {});
    heard += tasks.take(16, [](const wire::Task&, const dds_sample_info_t&) {});
  }
  std::printf("heard %zu samples\n", heard);
  return 0;
}

// As `worker`: damaged answers to the batches that it may hold, and a farewell.
void forge_for(std::uint64_t worker, const wire::Control& control, wire::Writer<wire::Answer>& answers,
               wire::Writer<wire::Hello>& hellos) {
  constexpr std::uint64_t kBatches = 2000;  // they are numbered from 0
  const std::vector<std::uint8_t> garbage(100, 0xAB);
  wire::Answer answer{};
  answer.protocol = control.protocol;
  answer.run_id = control.run_id;
  answer.chain = control.chain;
  answer.worker = worker;
  answer.outcome = coppice_wire_EVALUATED;
  answer.payload = wire::lend(garbage);
  for (answer.batch = 0; answer.batch < kBatches; ++answer.batch) {
    if (auto ok = answers.write(answer); !ok) {
      std::exit(fail(ok.error().message));
    }
  }
  wire::Hello hello{};
  hello.protocol = control.protocol;
  hello.worker = worker;
  hello.golden = control.golden;
  hello.run_id = control.run_id;
  hello.leaving = true;
  if (auto ok = hellos.write(hello); !ok) {
    std::exit(fail(ok.error().message));
  }
}

int forge(std::uint32_t domain, const wire::Network& network) {
  const auto participant = join(domain, network);
  const auto controls = required(wire::Reader<wire::Control>::make(participant));
  const auto fleets = required(wire::Reader<wire::Fleet>::make(participant));
  auto waiter = required(wire::Waiter::make(participant));
  if (!waiter.watch_reader(fleets.get())) {
    return fail("cannot wait");
  }
  auto hellos = required(wire::Writer<wire::Hello>::make(participant));
  auto answers = required(wire::Writer<wire::Answer>::make(participant));
  wire::Control control{};
  std::set<std::uint64_t> forged;
  std::chrono::steady_clock::time_point end{};
  for (int i = 0; i < kMostWaits && (forged.empty() || std::chrono::steady_clock::now() < end); ++i) {
    waiter.wait(std::chrono::milliseconds(100));
    controls.take(16, [&](const wire::Control& sample, const dds_sample_info_t& info) {
      control = info.valid_data ? sample : control;
    });
    fleets.take(16, [&](const wire::Fleet& fleet, const dds_sample_info_t& info) {
      if (!info.valid_data || control.run_id == 0) {
        return;
      }
      if (forged.empty() && fleet.workers._length > 0) {
        end = std::chrono::steady_clock::now() + kKnockingTime;
      }
      for (std::uint32_t worker = 0; worker < fleet.workers._length; ++worker) {
        forged.insert(fleet.workers._buffer[worker].worker);
        forge_for(fleet.workers._buffer[worker].worker, control, answers, hellos);
      }
    });
  }
  std::printf("forged %zu names\n", forged.size());
  return forged.empty() ? fail("nobody to forge for") : 0;
}

// A writer as DDS makes it by default: what it unregisters it disposes of.
dds_entity_t plain_writer(const wire::Participant& participant) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
  dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 1);
  dds_qset_liveliness(qos, DDS_LIVELINESS_AUTOMATIC, DDS_MSECS(wire::kLivelinessLeaseMs));
  static const dds_entity_t topic =
      dds_create_topic(participant.get(), &coppice_wire_Hello_desc, "coppice_Hello", qos, nullptr);
  const dds_entity_t writer = dds_create_writer(participant.get(), topic, qos, nullptr);
  dds_delete_qos(qos);
  return writer < 0 ? std::exit(fail(dds_strretcode(-writer))), writer : writer;
}

void await_match(dds_entity_t writer) {
  dds_publication_matched_status_t status{};
  for (int i = 0; i < kMostWaits && status.current_count == 0; ++i) {
    dds_get_publication_matched_status(writer, &status);
    dds_sleepfor(DDS_MSECS(10));
  }
}

void take_away(std::string_view way, const wire::Participant& participant, dds_entity_t writer, wire::Hello hello) {
  if (way == "unregister") {
    dds_instance_handle_t handle = 0;
    dds_register_instance(writer, &handle, &hello);
    dds_unregister_instance(writer, &hello);
    return;
  }
  if (way == "vanish") {
    hello.leaving = true;
    const dds_entity_t brief = plain_writer(participant);
    await_match(brief);
    dds_write(brief, &hello);
    dds_delete(brief);
    return;
  }
  dds_dispose(writer, &hello);
  if (way == "steal") {
    dds_write(writer, &hello);
  }
}

int take_workers_away(std::uint32_t domain, const wire::Network& network, std::string_view way) {
  constexpr std::chrono::seconds kTime{2};
  constexpr std::chrono::milliseconds kInterval{20};
  const auto participant = join(domain, network);
  const auto controls = required(wire::Reader<wire::Control>::make(participant));
  const auto fleets = required(wire::Reader<wire::Fleet>::make(participant));
  auto waiter = required(wire::Waiter::make(participant));
  const dds_entity_t writer = plain_writer(participant);
  await_match(writer);
  wire::Control control{};
  std::set<std::uint64_t> names;
  std::chrono::steady_clock::time_point end{};
  for (int i = 0; i < kMostWaits * 5 && (names.empty() || std::chrono::steady_clock::now() < end); ++i) {
    waiter.wait(kInterval);
    controls.take(16, [&](const wire::Control& sample, const dds_sample_info_t& info) {
      control = info.valid_data ? sample : control;
    });
    fleets.take(16, [&](const wire::Fleet& fleet, const dds_sample_info_t& info) {
      if (!info.valid_data || control.run_id == 0 || fleet.workers._length == 0) {
        return;
      }
      if (names.empty()) {
        end = std::chrono::steady_clock::now() + kTime;
      }
      for (std::uint32_t worker = 0; worker < fleet.workers._length; ++worker) {
        names.insert(fleet.workers._buffer[worker].worker);
      }
    });
    for (const std::uint64_t name : names) {
      wire::Hello hello{};
      hello.protocol = wire::kProtocolVersion;
      hello.golden = control.golden;
      hello.worker = name;
      hello.run_id = control.run_id;
      hello.threads = 1;
      hello.chains = {1, 1, &control.chain, false};
      take_away(way, participant, writer, hello);
    }
  }
  std::printf("attacked %zu names\n", names.size());
  return names.empty() ? fail("nobody to take away") : 0;
}

template <typename Sample>
void try_to_write(const wire::Participant& participant, const char* name) {
  auto writer = wire::Writer<Sample>::make(participant);
  std::printf("%s: %s\n", name, writer ? "allowed" : writer.error().message.c_str());
}

int rule(std::uint32_t domain, const wire::Network& network) {
  const auto participant = join(domain, network);
  try_to_write<wire::Control>(participant, "Control");
  try_to_write<wire::Task>(participant, "Task");
  try_to_write<wire::ChainBlock>(participant, "ChainBlock");
  try_to_write<wire::Hello>(participant, "Hello");
  return 0;
}

int mislead(std::uint32_t domain, const wire::Network& network, const std::string& port) {
  constexpr std::chrono::seconds kTime{2};
  std::string configuration = required(wire::worker_configuration("127.0.0.1", domain, network));
  const std::string peers = "<Peers>";
  configuration.insert(configuration.find(peers) + peers.size(), "<Peer Address=\"127.0.0.1:" + port + "\"/>");
  const auto participant = required(wire::Participant::join(domain, configuration));
  auto controls = required(wire::Writer<wire::Control>::make(participant));
  await_match(controls.get());
  wire::Control control{};
  control.run_id = 0xE71;
  wire::put_text(control.host, "misleader");
  const auto end = std::chrono::steady_clock::now() + kTime;
  while (std::chrono::steady_clock::now() < end) {
    for (const bool version : {true, false}) {
      control.protocol = wire::kProtocolVersion + (version ? 1 : 0);
      control.golden = golden_checksum() + 1;
      if (auto ok = controls.write(control); !ok) {
        return fail(ok.error().message);
      }
      dds_dispose(controls.get(), &control);
    }
    dds_sleepfor(DDS_MSECS(5));
  }
  return controls.matched() && controls.wait_for_acknowledgements(kAcknowledgeMs) ? 0
                                                                                  : fail("the worker did not hear it");
}

int serve_as(std::uint32_t domain, std::uint32_t protocol, std::uint64_t golden) {
  block_stop_signals();
  StopFlag stop;
  const StopOnSignals signals(stop);
  ServeOptions options;
  options.domain = domain;
  options.protocol = protocol;
  options.golden = golden;
  options.version = "99.0";
  const auto served = serve(options, stop);
  return served ? 0 : fail(served.error().message);
}

}  // namespace

int main(int argc, char** argv) {
  const std::string_view mode(argc > 2 ? argv[2] : "");
  if (mode == "usurp" ? argc != 6 : mode == "mislead" ? argc != 5 : argc != 3 && argc != 4) {
    return fail(
        "usage: stranger DOMAIN noise|next|build|knock|forge|rule [IDENTITY], stranger DOMAIN mislead IDENTITY PORT, "
        "or stranger DOMAIN usurp IDENTITY RULES "
        "PORT");
  }
  const auto domain = static_cast<std::uint32_t>(std::strtoul(argv[1], nullptr, 10));
  wire::Network network;
  network.security = argc > 3 && std::string_view(argv[3]) != "-" ? argv[3] : "";
  if (mode == "usurp") {
    return e2e::usurp({domain, network, argv[4], argv[5]});
  }
  if (mode == "mislead") {
    return mislead(domain, network, argv[4]);
  }
  if (mode == "noise") {
    return make_noise(domain, network);
  }
  if (mode == "knock") {
    return knock(domain, network);
  }
  if (mode == "forge") {
    return forge(domain, network);
  }
  if (mode == "dispose" || mode == "unregister" || mode == "vanish" || mode == "steal") {
    return take_workers_away(domain, network, mode);
  }
  if (mode == "rule") {
    return rule(domain, network);
  }
  return mode == "build" ? serve_as(domain, wire::kProtocolVersion, golden_checksum() + 1)
                         : serve_as(domain, wire::kProtocolVersion + 1, golden_checksum());
}
