#include "worker/echo.hpp"

#include <algorithm>
#include <chrono>
#include <spdlog/spdlog.h>
#include <unistd.h>
#include <vector>

#include "common/chain/bytes.hpp"
#include "common/wire/topics.hpp"
#include "common/wire/waiter.hpp"

namespace coppice {
namespace {

constexpr std::chrono::seconds kIdleEchoWait{1};

void answer(const wire::Task& task, std::uint64_t identity, std::vector<std::uint8_t>& payload,
            wire::Writer<wire::Answer>& answers) {
  ByteReader reader(wire::view(task.payload));
  payload.resize(std::min<std::size_t>(reader.get<std::uint32_t>(), wire::kMaxTaskPayload));
  wire::Answer sample{};
  sample.protocol = task.protocol;
  sample.run_id = task.run_id;
  sample.worker = identity;
  sample.batch = task.batch;
  sample.outcome = coppice_wire_EVALUATED;
  sample.payload = wire::lend(payload);
  if (auto ok = answers.write(sample); !ok) {
    spdlog::warn("an answer was not sent: {}", ok.error().message);
  }
}

}  // namespace

Result<void> echo(const ServeOptions& options, const StopFlag& stop) {
  const auto configuration = wire::worker_configuration(options.coordinator, options.domain, options.network);
  if (!configuration) {
    return tl::unexpected(configuration.error());
  }
  const auto participant = wire::Participant::join(options.domain, *configuration);
  if (!participant) {
    return tl::unexpected(participant.error());
  }
  const std::uint64_t identity = wire::random_identity();
  auto waiter = wire::Waiter::make(*participant);
  auto tasks = wire::Reader<wire::Task>::make(*participant, wire::partition_of(identity));
  auto answers = wire::Writer<wire::Answer>::make(*participant);
  auto hellos = wire::Writer<wire::Hello>::make(*participant);
  for (const Error* error : {waiter ? nullptr : &waiter.error(), tasks ? nullptr : &tasks.error(),
                             answers ? nullptr : &answers.error(), hellos ? nullptr : &hellos.error()}) {
    if (error != nullptr) {
      return tl::unexpected(*error);
    }
  }
  if (auto ok = waiter->watch_reader(tasks->get()); !ok) {
    return ok;
  }
  const auto wake = stop.on_raise([&waiter] { waiter->wake(); });
  wire::Hello hello{};
  hello.protocol = options.protocol;
  hello.worker = identity;
  hello.pid = static_cast<std::uint32_t>(getpid());
  hello.threads = 1;
  if (auto ok = hellos->write(hello); !ok) {
    return ok;
  }
  std::vector<std::uint8_t> payload;
  while (!stop.raised()) {
    const std::size_t taken = tasks->take(1, [&](const wire::Task& task, const dds_sample_info_t& info) {
      if (info.valid_data) {
        answer(task, identity, payload, *answers);
      }
    });
    if (taken == 0) {
      waiter->wait(kIdleEchoWait);
    }
  }
  return {};
}

}  // namespace coppice
