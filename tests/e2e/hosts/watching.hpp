// What Prometheus and a service manager see of real programs.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>

#include "tests/e2e/hosts/remote_study.hpp"

namespace coppice::e2e {

class Watching : public RemoteStudy {
 protected:
  static constexpr int kMostLooks = 100;

  // The metrics at a URL's port, or in a file.
  static nlohmann::json scrape(const std::string& where) {
    const Completed read = run_to_end(
        {.program = "/usr/bin/python3", .arguments = {COPPICE_SOURCE_DIR "/tests/e2e/hosts/scrape.py", where}});
    EXPECT_EQ(read.ending, kDone) << read.error;
    return nlohmann::json::parse(read.output, nullptr, false);
  }
  // That a program says it listens at.
  static std::string port_of(Process& process) {
    const std::string line = process.await_error("metrics at port ");
    const std::string rest = line.substr(line.find("port ") + 5);
    return rest.substr(0, rest.find(' '));
  }
  static std::string url(const std::string& port) { return "http://127.0.0.1:" + port + "/metrics"; }

  // The value of the sample with these labels; none: there is no such sample.
  static std::optional<double> value(const nlohmann::json& metrics, const std::string& name,
                                     const std::map<std::string, std::string>& labels = {}) {
    if (!metrics.contains(name)) {
      return std::nullopt;
    }
    for (const auto& sample : metrics[name]) {
      bool all = true;
      for (const auto& [label, wanted] : labels) {
        all = all && sample[0].contains(label) && sample[0][label] == wanted;
      }
      if (all) {
        return sample[1].get<double>();
      }
    }
    return std::nullopt;
  }

  // Looks until it holds.
  static nlohmann::json scrape_until(const std::string& where,
                                     const std::function<bool(const nlohmann::json&)>& holds) {
    nlohmann::json metrics;
    for (int i = 0; i < kMostLooks; ++i) {
      metrics = scrape(where);
      if (holds(metrics)) {
        return metrics;
      }
    }
    ADD_FAILURE() << "never became what was awaited: " << metrics.dump();
    return metrics;
  }
};

}  // namespace coppice::e2e
