// One worker as a person is shown it. Texts in it come from the network and are fit for a terminal.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/wire/topics.hpp"

namespace coppice {

struct ListedWorker {
  std::string host;
  std::uint32_t pid = 0;
  std::uint32_t cores = 0;
  std::uint32_t threads = 0;
  std::uint32_t protocol = 0;
  std::string version;
  std::string doing;                  // in a few words
  std::uint64_t evaluated = 0;        // individuals since its start
  std::uint64_t each_second = 0;      // of them, lately
  std::chrono::milliseconds seen{0};  // since its last sign of life
};

ListedWorker listed(const wire::WorkerStatus& status, std::string doing);
// By what its coordinator says of it.
ListedWorker listed(const wire::WorkerStatus& status);

// Hears of a coordinator's workers twice a second, on the thread that dispatches.
using WatchWorkers = std::function<void(const std::vector<ListedWorker>&)>;

}  // namespace coppice
