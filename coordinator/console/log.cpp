#include "coordinator/console/log.hpp"

#include <fmt/format.h>
#include <memory>
#include <mutex>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>
#include <string_view>
#include <unistd.h>
#include <utility>

#include "common/json_log.hpp"
#include "coordinator/console/best_effort.hpp"
#include "coordinator/console/printable.hpp"

namespace coppice {
namespace {

constexpr std::uint32_t kLinesPerWindow = 20;
constexpr std::chrono::milliseconds kWindow{1000};

class StandardErrorSink : public spdlog::sinks::base_sink<std::mutex> {
 public:
  StandardErrorSink(std::FILE* out, LogFormat format)
      : out_(out),
        format_(format),
        clear_line_(isatty(fileno(out)) == 1 ? "\r\x1b[K" : ""),
        budget_(kLinesPerWindow, kWindow) {}

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    const LineBudget::Verdict verdict = budget_.next(message.time);
    if (verdict.left_out > 0) {
      spdlog::details::log_msg left_out = message;
      const std::string text = fmt::format("{} messages left out", verdict.left_out);
      left_out.payload = text;
      show_line(left_out);
    }
    if (verdict.shown) {
      show_line(message);
    }
  }
  void flush_() override { static_cast<void>(std::fflush(out_)); }

 private:
  void show_line(const spdlog::details::log_msg& message) {
    const std::string_view text(message.payload.data(), message.payload.size());
    show(out_, format_ == LogFormat::json ? fmt::format("{}{}\n", clear_line_, json_log_line(message, "coppice"))
                                          : fmt::format("{}coppice: {}\n", clear_line_, printable(text)));
  }

  std::FILE* out_;
  LogFormat format_;
  const char* clear_line_;
  LineBudget budget_;
};

}  // namespace

LineBudget::Verdict LineBudget::next(Time now) {
  Verdict verdict;
  if (now - window_begin_ >= window_) {
    window_begin_ = now;
    used_ = 0;
    verdict.left_out = left_out_;
    left_out_ = 0;
  }
  if (used_ == lines_) {
    ++left_out_;
    return verdict;
  }
  ++used_;
  verdict.shown = true;
  return verdict;
}

void log_to(std::FILE* out, spdlog::level::level_enum level, LogFormat format) {
  auto logger = std::make_shared<spdlog::logger>("coppice", std::make_shared<StandardErrorSink>(out, format));
  logger->set_level(level);
  logger->flush_on(spdlog::level::trace);
  spdlog::set_default_logger(std::move(logger));
}

}  // namespace coppice
