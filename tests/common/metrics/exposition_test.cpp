#include "common/metrics/exposition.hpp"

#include <gtest/gtest.h>

namespace coppice {
namespace {

TEST(Exposition, GathersAFamilyUnderOneNameWithOneHelp) {
  Exposition out;
  out.counter("x_total", "How often.", 3, {{"kind", "a"}});
  out.gauge("y", "Now.", 0.5);
  out.counter("x_total", "", 4, {{"kind", "b"}});
  EXPECT_EQ(out.text(),
            "# HELP x_total How often.\n# TYPE x_total counter\n"
            "x_total{kind=\"a\"} 3\nx_total{kind=\"b\"} 4\n"
            "# HELP y Now.\n# TYPE y gauge\ny 0.5\n");
}

TEST(Exposition, MakesLabelsOfAnyBytesFitForPrometheus) {
  Exposition out;
  out.gauge("x", "X.", 1, {{"source", "quote \" back \\ line \n, \xC3\xA4, \xFF, \xC3"}});
  EXPECT_NE(out.text().find("x{source=\"quote \\\" back \\\\ line \\n, \xC3\xA4, ?, ?\"} 1\n"), std::string::npos)
      << out.text();
}

TEST(Exposition, KnowsItsOwnProcess) {
  Exposition out;
  add_process(out);
  for (const char* name : {"process_cpu_seconds_total ", "process_resident_memory_bytes ", "process_open_fds ",
                           "process_start_time_seconds "}) {
    const std::size_t at = out.text().find(std::string("\n") + name);
    ASSERT_NE(at, std::string::npos) << name;
    EXPECT_GT(std::stod(out.text().substr(at + 1 + std::string(name).size())), 0.0) << name;
  }
}

TEST(ExpositionDeathTest, RefusesANameThatPrometheusWouldNot) {
  Exposition out;
  EXPECT_DEATH(out.gauge("no name", "", 1), "CheckMetricName");
}

}  // namespace
}  // namespace coppice
