// Where a program's figures can be had: by HTTP from an address of the user's choice (libmicrohttpd), and in a file for
// the textfile collector of Prometheus' node exporter.
//
//   GET /metrics   the figures, in Prometheus' text format
//   GET /health    200 while the program is alive, else 503; a line says how it does. Programs that can tell only
//   GET /ready     likewise, while it can be used: a worker that serves a coordinator
//
// Nobody is asked who he is: whoever reaches the address reads the figures. So it is loopback unless the user says
// otherwise.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "common/error.hpp"

namespace coppice {

struct MetricsPlace {
  std::string address = "127.0.0.1";  // IPv4 or IPv6, numeric
  std::uint16_t port = 0;             // 0: one that is free
};

// "9470", "0.0.0.0:9470", "[::1]:9470". Errors (bad_input) name `flag`.
Result<MetricsPlace> metrics_place(const std::string& flag, const std::string& text);

struct MetricsTargets {
  std::string place;  // --metrics; empty: none
  std::string file;   // --metrics-file; empty: none
  bool any() const { return !place.empty() || !file.empty(); }
};

struct Health {
  bool alive = true;
  bool ready = true;
  std::string words;  // a line
};

class MetricsOutlet {
 public:
  // Called from threads of the outlet's own, several at a time.
  struct Source {
    std::function<std::string()> text;
    std::function<Health()> health = {};  // may be empty
  };

  // The file is written at once, every 5 s and at the end, whole, readable by everybody. Errors (bad_input) name the
  // flag: what is no address, an address that cannot be listened on, a file that cannot be written.
  static Result<std::unique_ptr<MetricsOutlet>> open(const MetricsTargets& targets, Source source);
  virtual ~MetricsOutlet() = default;

  // That is listened on; 0: none.
  virtual std::uint16_t port() const = 0;
};

// Asks a program of ours, as a health check does. Its line, also where it says no (failed). Errors name `flag`.
Result<std::string> ask_health(const std::string& flag, const std::string& place, const std::string& path);

}  // namespace coppice
