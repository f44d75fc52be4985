// What an evolution left in a study, without the figures that say how and how fast it was computed: two evolutions of
// the same study, seed and configuration have the same, whatever happened to either.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "tests/e2e/cli/command_line.hpp"

namespace coppice::e2e {

class EvolvedStudy : public CommandLine {
 protected:
  void SetUp() override { learn_study(); }

  static std::vector<std::string> evolve(const std::string& study, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"evolve", study};
    const auto has = [&](const char* flag) { return std::find(more.begin(), more.end(), flag) != more.end(); };
    if (!has("--config") && !has("--resume")) {  // the quickest
      arguments.insert(arguments.end(), {"--config", "thesis"});
    }
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  static nlohmann::json figures(nlohmann::json report) {
    for (const char* differs : {"study", "evaluator", "seconds", "dispatch"}) {
      report.erase(differs);
    }
    return report;
  }

  // Every run's result and every generation's statistics, as the study holds them.
  nlohmann::json runs(const std::string& study) const {
    nlohmann::json list = coppice_json({"info", study, "--json"})["runs"];
    for (nlohmann::json& run : list) {
      for (const char* differs : {"evaluator", "started", "ended"}) {
        run.erase(differs);
      }
      if (run.contains("result")) {
        run["result"] = figures(run["result"]);
      }
    }
    return list;
  }

  // Says which run and generation differ, instead of printing all of both.
  void expect_same_runs(const std::string& study, const nlohmann::json& expected) const {
    const nlohmann::json found = runs(study);
    if (found == expected) {
      return;
    }
    for (std::size_t run = 0; run < std::min(found.size(), expected.size()); ++run) {
      for (std::size_t i = 0; i < std::min(found[run]["statistics"].size(), expected[run]["statistics"].size()); ++i) {
        ASSERT_EQ(found[run]["statistics"][i], expected[run]["statistics"][i]) << "run " << run + 1;
      }
      ASSERT_EQ(found[run]["status"], expected[run]["status"]) << "run " << run + 1;
      ASSERT_EQ(found[run]["tree"], expected[run]["tree"]) << "run " << run + 1;
    }
    FAIL() << "the runs differ in more than their generations and trees";
  }

  // The same, after a serial evolution of a copy of study.coppice, which must not have been evolved yet.
  nlohmann::json serial_runs(std::vector<std::string> settings) const {
    write("serial.coppice", read("study.coppice"));
    settings.insert(settings.end(), {"--serial", "--json"});
    coppice_json(evolve("serial.coppice", settings));
    return runs("serial.coppice");
  }
};

}  // namespace coppice::e2e
