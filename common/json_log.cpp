#include "common/json_log.hpp"

#include <chrono>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <mutex>
#include <nlohmann/json.hpp>
#include <spdlog/sinks/base_sink.h>
#include <unistd.h>
#include <utility>

namespace coppice {
namespace {

class JsonSink : public spdlog::sinks::base_sink<std::mutex> {
 public:
  JsonSink(std::FILE* out, std::string program) : out_(out), program_(std::move(program)) {}

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    const std::string line = json_log_line(message, program_) + "\n";
    // A log that cannot be written stops nobody.
    static_cast<void>(std::fwrite(line.data(), 1, line.size(), out_));
    static_cast<void>(std::fflush(out_));
  }
  void flush_() override { static_cast<void>(std::fflush(out_)); }

 private:
  std::FILE* out_;
  std::string program_;
};

}  // namespace

std::string json_log_line(const spdlog::details::log_msg& message, std::string_view program) {
  using std::chrono::milliseconds;
  const auto since = std::chrono::duration_cast<milliseconds>(message.time.time_since_epoch());
  const auto level = spdlog::level::to_string_view(message.level);
  const nlohmann::ordered_json line = {
      {"time", fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z", fmt::gmtime(since.count() / 1000), since.count() % 1000)},
      {"level", std::string(level.data(), level.size())},
      {"program", program},
      {"pid", getpid()},
      {"message", std::string(message.payload.data(), message.payload.size())}};
  return line.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

std::shared_ptr<spdlog::sinks::sink> json_log_sink(std::FILE* out, std::string program) {
  return std::make_shared<JsonSink>(out, std::move(program));
}

}  // namespace coppice
