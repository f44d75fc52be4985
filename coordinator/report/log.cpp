#include "coordinator/report/log.hpp"

#include <fmt/format.h>
#include <memory>
#include <mutex>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>
#include <string_view>
#include <unistd.h>
#include <utility>

#include "coordinator/report/best_effort.hpp"
#include "coordinator/report/printable.hpp"

namespace coppice {
namespace {

constexpr std::uint32_t kLinesPerWindow = 20;
constexpr std::chrono::milliseconds kWindow{1000};

class StandardErrorSink : public spdlog::sinks::base_sink<std::mutex> {
 public:
  explicit StandardErrorSink(std::FILE* out)
      : out_(out), clear_line_(isatty(fileno(out)) == 1 ? "\r\x1b[K" : ""), budget_(kLinesPerWindow, kWindow) {}

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    const LineBudget::Verdict verdict = budget_.next(message.time);
    if (verdict.left_out > 0) {
      show(out_, fmt::format("{}coppice: {} messages left out\n", clear_line_, verdict.left_out));
    }
    if (verdict.shown) {
      const std::string_view text(message.payload.data(), message.payload.size());
      show(out_, fmt::format("{}coppice: {}\n", clear_line_, printable(text)));
    }
  }
  void flush_() override { static_cast<void>(std::fflush(out_)); }

 private:
  std::FILE* out_;
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

void log_to(std::FILE* out, spdlog::level::level_enum level) {
  auto logger = std::make_shared<spdlog::logger>("coppice", std::make_shared<StandardErrorSink>(out));
  logger->set_level(level);
  logger->flush_on(spdlog::level::trace);
  spdlog::set_default_logger(std::move(logger));
}

}  // namespace coppice
