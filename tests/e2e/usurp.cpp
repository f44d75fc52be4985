#include "tests/e2e/usurp.hpp"

#include <cstdio>
#include <cstdlib>
#include <optional>
#include <vector>

#include "common/fitness/golden_job.hpp"
#include "common/wire/topics.hpp"
#include "common/wire/waiter.hpp"

namespace coppice::e2e {
namespace {

constexpr int kMostWaits = 600;  // of 100 ms, for the coordinator's announcement: for one that must be let in
constexpr int kFewWaits = 20;
constexpr std::chrono::seconds kUsurpingTime{3};
constexpr std::int64_t kAcknowledgeMs = 500;

template <typename T>
T required(Result<T> result) {
  if (!result) {
    std::fprintf(stderr, "stranger: %s\n", result.error().message.c_str());
    std::exit(1);
  }
  return std::move(*result);
}

void put_in(std::string& text, const std::string& after, const std::string& more) {
  if (const std::size_t at = text.find(after); at != std::string::npos) {
    text.insert(at + after.size(), more);
  }
}

wire::Participant join(const Usurper& usurper) {
  std::string configuration = required(wire::worker_configuration("127.0.0.1", usurper.domain, usurper.network));
  put_in(configuration, "<Peers>", "<Peer Address=\"127.0.0.1:" + usurper.worker_port + "\"/>");
  if (usurper.rules != "own") {
    put_in(configuration, "<AccessControl>",
           "<Library path=\"" COPPICE_LAWLESS "\" initFunction=\"" + usurper.rules +
               "\" finalizeFunction=\"finalize_lawless\"/>");
  }
  return required(wire::Participant::join(usurper.domain, configuration));
}

// Everything that a coordinator may write, for all workers at once.
class Orders {
 public:
  explicit Orders(const wire::Participant& participant)
      : controls_(required(wire::Writer<wire::Control>::make(participant))),
        fleets_(required(wire::Writer<wire::Fleet>::make(participant))),
        tasks_(required(wire::Writer<wire::Task>::make(participant, "*"))),
        blocks_(required(wire::Writer<wire::ChainBlock>::make(participant, "*"))) {}

  // In the name of the run that was heard of, or of one's own.
  void give(const std::optional<wire::Control>& heard) {
    const std::vector<std::uint8_t> garbage(100, 0xAB);
    wire::Control control{};
    control.protocol = wire::kProtocolVersion;
    control.run_id = 0xE71;
    control.golden = golden_checksum();
    wire::put_text(control.host, "usurper");
    control.chain_size = 1'000'000;
    wire::Task task{};
    task.protocol = wire::kProtocolVersion;
    task.run_id = heard ? heard->run_id : control.run_id;
    task.chain = heard ? heard->chain : control.chain;
    task.payload = wire::lend(garbage);
    wire::ChainBlock block{};
    block.protocol = task.protocol;
    block.run_id = task.run_id;
    block.chain = task.chain;
    block.payload = wire::lend(garbage);
    wire::Fleet fleet{};
    fleet.protocol = wire::kProtocolVersion;
    if (!controls_.write(control) || !tasks_.write(task) || !blocks_.write(block) || !fleets_.write(fleet)) {
      std::fputs("stranger: an order could not be written\n", stderr);
    }
  }

  void print() const {
    std::printf("matched by own rules: %d\n", tasks_.matched() ? 1 : 0);
    std::printf("reached: control %d, task %d, block %d\n", reached(controls_), reached(tasks_), reached(blocks_));
  }

 private:
  // Some reader is there, by our own rules, and has it.
  template <typename Sample>
  static int reached(const wire::Writer<Sample>& writer) {
    return writer.matched() && writer.wait_for_acknowledgements(kAcknowledgeMs) ? 1 : 0;
  }

  wire::Writer<wire::Control> controls_;
  wire::Writer<wire::Fleet> fleets_;
  wire::Writer<wire::Task> tasks_;
  wire::Writer<wire::ChainBlock> blocks_;
};

// The reader is gone on return: it would count as one that the orders reached.
std::optional<wire::Control> await_control(const wire::Participant& participant, wire::Waiter& waiter, int most_waits) {
  const auto controls = required(wire::Reader<wire::Control>::make(participant));
  std::optional<wire::Control> control;
  for (int i = 0; i < most_waits && !control; ++i) {
    waiter.wait(std::chrono::milliseconds(100));
    controls.take(16, [&](const wire::Control& sample, const dds_sample_info_t& info) {
      if (info.valid_data) {
        control = sample;
      }
    });
  }
  return control;
}

}  // namespace

int usurp(const Usurper& usurper) {
  const auto participant = join(usurper);
  auto waiter = required(wire::Waiter::make(participant));
  const auto hellos = required(wire::Reader<wire::Hello>::make(participant));
  const auto answers = required(wire::Reader<wire::Answer>::make(participant));
  const auto requests = required(wire::Reader<wire::ChainRequest>::make(participant));
  const auto control = await_control(participant, waiter, usurper.rules == "init_lawless" ? kMostWaits : kFewWaits);
  Orders orders(participant);
  std::size_t heard = 0;
  const auto end = std::chrono::steady_clock::now() + kUsurpingTime;
  while (std::chrono::steady_clock::now() < end) {
    orders.give(control);
    waiter.wait(std::chrono::milliseconds(100));
    const auto count = [](const auto&, const dds_sample_info_t&) {};
    heard += hellos.take(64, count) + answers.take(64, count) + requests.take(64, count);
  }
  orders.print();
  std::printf("heard: control %d, what is meant for the coordinator %d\n", control ? 1 : 0, heard > 0 ? 1 : 0);
  return 0;
}

}  // namespace coppice::e2e
