#include "common/metrics/exposition.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <prometheus/check_names.h>
#include <prometheus/text_serializer.h>
#include <sstream>
#include <string_view>
#include <sys/resource.h>
#include <unistd.h>

#include "common/check.hpp"

namespace coppice {
namespace {

// Length of the UTF-8 character at the front, 0 if there is none (RFC 3629; overlong forms of two bytes are none).
std::size_t character_at(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
  const std::size_t length = byte(0) < 0x80U                       ? 1
                             : byte(0) >= 0xC2U && byte(0) < 0xE0U ? 2
                             : (byte(0) & 0xF0U) == 0xE0U          ? 3
                             : byte(0) >= 0xF0U && byte(0) < 0xF5U ? 4
                                                                   : 0;
  if (length == 0 || length > text.size()) {
    return 0;
  }
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0U) != 0x80U) {
      return 0;
    }
  }
  return length;
}

std::string as_utf8(std::string_view text) {
  std::string result;
  while (!text.empty()) {
    const std::size_t length = character_at(text);
    result += length == 0 ? "?" : text.substr(0, length);
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return result;
}

}  // namespace

prometheus::ClientMetric& Exposition::add(const std::string& name, const std::string& help, prometheus::MetricType type,
                                          const Labels& labels) {
  COPPICE_CHECK(prometheus::CheckMetricName(name));
  auto family = std::find_if(families_.begin(), families_.end(), [&](const auto& known) { return known.name == name; });
  if (family == families_.end()) {
    families_.push_back({name, help, type, {}});
    family = std::prev(families_.end());
  }
  COPPICE_CHECK(family->type == type);
  prometheus::ClientMetric metric;
  for (const auto& [label, value] : labels) {
    metric.label.push_back({label, as_utf8(value)});
  }
  family->metric.push_back(std::move(metric));
  return family->metric.back();
}

void Exposition::counter(const std::string& name, const std::string& help, double value, const Labels& labels) {
  add(name, help, prometheus::MetricType::Counter, labels).counter.value = value;
}

void Exposition::gauge(const std::string& name, const std::string& help, double value, const Labels& labels) {
  add(name, help, prometheus::MetricType::Gauge, labels).gauge.value = value;
}

std::string Exposition::text() const {
  std::ostringstream out;
  prometheus::TextSerializer().Serialize(out, families_);
  return out.str();
}

namespace {

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) / 1e6;
}

double resident_bytes() {
  std::ifstream file("/proc/self/statm");
  std::uint64_t size = 0;
  std::uint64_t resident = 0;
  file >> size >> resident;
  return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE));
}

std::size_t open_files() {
  std::error_code error;
  std::size_t count = 0;
  for (std::filesystem::directory_iterator entry("/proc/self/fd", error), end; !error && entry != end;
       entry.increment(error)) {
    ++count;
  }
  return count;
}

double now_in_unix_time() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

const double started = now_in_unix_time();  // this file is loaded with the program

}  // namespace

void add_process(Exposition& exposition) {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  exposition.counter("process_cpu_seconds_total", "Processor time of this process, user and system.",
                     seconds_of(usage.ru_utime) + seconds_of(usage.ru_stime));
  exposition.gauge("process_resident_memory_bytes", "Resident memory of this process.", resident_bytes());
  exposition.gauge("process_open_fds", "Open file descriptors of this process.", static_cast<double>(open_files()));
  exposition.gauge("process_start_time_seconds", "When this process started, in Unix time.", started);
}

}  // namespace coppice
