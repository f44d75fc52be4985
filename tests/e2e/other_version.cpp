// A worker of another version of Coppice, for the tests of an upgrade: coppice-worker, but that it speaks the next
// protocol, or computes otherwise. It takes the flags --coordinator and --domain in this order, as the tests give them.
//   other_version protocol|build --coordinator HOST --domain DOMAIN
#include <cstdio>
#include <cstdlib>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <string_view>

#include "common/exit_code.hpp"
#include "common/stop.hpp"
#include "common/wire/topics.hpp"
#include "worker/serve.hpp"

int main(int argc, char** argv) {
  if (argc < 6 || std::string_view(argv[2]) != "--coordinator" || std::string_view(argv[4]) != "--domain") {
    return coppice::to_int(coppice::ExitCode::wrong_use);
  }
  spdlog::set_default_logger(spdlog::stderr_color_mt("other-version"));
  coppice::block_stop_signals();
  coppice::StopFlag stop;
  const coppice::StopOnSignals signals(stop);
  coppice::ServeOptions options;
  options.coordinator = argv[3];
  options.domain = static_cast<std::uint32_t>(std::strtoul(argv[5], nullptr, 10));
  options.protocol = coppice::wire::kProtocolVersion;
  options.version = "0.9.9";
  if (std::string_view(argv[1]) == "protocol") {
    ++options.protocol;
  } else {
    ++options.golden;
  }
  const auto served = coppice::serve(options, stop);
  if (!served) {
    spdlog::error("{}", served.error().message);
    return coppice::to_int(coppice::exit_code_of(served.error()));
  }
  return 0;
}
