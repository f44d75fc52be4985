// Who is on a domain, for those who only look: asked of its coordinator, or, where there is none, heard from the
// workers that wait for one. Texts in it come from the network and are fit for a terminal.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "common/stop.hpp"
#include "coordinator/fleet/listed_worker.hpp"

namespace coppice {

struct WorkerList {
  struct Coordinator {
    std::string host;
    std::uint32_t pid = 0;
    std::string version;
    std::string chain;  // hash
  };
  std::optional<Coordinator> coordinator;
  std::vector<ListedWorker> workers;  // by host, then pid
};

struct WorkerListOptions {
  std::uint32_t domain = 0;
  std::string coordinator;            // host; empty: this machine
  std::string interface;              // of this machine, by name or address; empty: any
  std::filesystem::path security;     // folder of a coordinator's identity; empty: none
  std::optional<std::uint16_t> port;  // of this machine, that a firewall lets the answer through; empty: any
  std::chrono::seconds patience{3};   // for a coordinator to answer
};

// How long it listens to workers where there is no coordinator. It holds the coordinator's port meanwhile.
inline constexpr std::chrono::milliseconds kListeningTime{1500};

// Errors: no such interface; a coordinator that does not answer; interrupted.
Result<WorkerList> list_workers(const WorkerListOptions& options, const StopFlag& stop);

}  // namespace coppice
