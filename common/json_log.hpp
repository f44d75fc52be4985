// A line of a log as JSON, for programs that gather logs: one object a line.
//
//   {"time":"2026-01-31T12:34:56.789Z","level":"warning","program":"coppice-worker","pid":4711,"message":"..."}
#pragma once

#include <cstdio>
#include <memory>
#include <spdlog/common.h>
#include <spdlog/details/log_msg.h>
#include <string>
#include <string_view>

namespace coppice {

// Without the line's end. Bytes that are no UTF-8 are replaced.
std::string json_log_line(const spdlog::details::log_msg& message, std::string_view program);

// Writes such lines to `out`, flushed one by one; safe from any thread.
std::shared_ptr<spdlog::sinks::sink> json_log_sink(std::FILE* out, std::string program);

}  // namespace coppice
