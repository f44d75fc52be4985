// Figures in Prometheus' text format, by prometheus-cpp: the only folder that knows it. A program collects what it has
// each time somebody asks, so a counter here is a total that is kept elsewhere.
#pragma once

#include <prometheus/metric_family.h>
#include <string>
#include <utility>
#include <vector>

namespace coppice {

class Exposition {
 public:
  using Labels = std::vector<std::pair<std::string, std::string>>;

  // A total since the start of the process. Calls with one name add to one family; its help is that of the first.
  // REQUIRES: names and labels are what Prometheus allows; a counter's name ends in _total.
  void counter(const std::string& name, const std::string& help, double value, const Labels& labels = {});
  // What holds now.
  void gauge(const std::string& name, const std::string& help, double value, const Labels& labels = {});

  // Values of labels may be any bytes; what is no UTF-8 becomes '?'.
  std::string text() const;

 private:
  prometheus::ClientMetric& add(const std::string& name, const std::string& help, prometheus::MetricType type,
                                const Labels& labels);

  std::vector<prometheus::MetricFamily> families_;
};

// What Prometheus' clients say of every process: processor time, memory, start, open files.
void add_process(Exposition& exposition);

}  // namespace coppice
