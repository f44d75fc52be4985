#include "coordinator/fleet/apart.hpp"

#include <array>
#include <cerrno>
#include <cstring>
#include <fmt/format.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/chain/bytes.hpp"
#include "coordinator/fleet/local_workers.hpp"
#include "coordinator/fleet/spawn.hpp"

namespace coppice {
namespace {

constexpr std::size_t kMostAnswer = std::size_t{64} * 1024 * 1024;

bool send_all(int socket, std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno != EINTR) {
      return false;
    }
    bytes = bytes.subspan(sent < 0 ? 0 : static_cast<std::size_t>(sent));
  }
  return true;
}

std::vector<std::uint8_t> receive_all(int socket) {
  std::vector<std::uint8_t> bytes;
  std::array<std::uint8_t, 65536> some;
  while (bytes.size() < kMostAnswer) {
    const ssize_t count = recv(socket, some.data(), some.size(), 0);
    if (count == 0 || (count < 0 && errno != EINTR)) {
      break;
    }
    bytes.insert(bytes.end(), some.begin(), some.begin() + std::max<ssize_t>(count, 0));
  }
  return bytes;
}

Result<pid_t> spawn(const std::filesystem::path& program, int socket) {
  const std::string name = program.string();
  const std::string parent = std::to_string(getpid());
  return spawn_in_own_group({name.c_str(), "--apart", "--parent", parent.c_str(), "--log-level", "error"}, socket);
}

}  // namespace

Result<std::unique_ptr<Apart>> Apart::start(Task task, std::function<void()> ended) {
  std::array<int, 2> sockets{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, sockets.data()) != 0) {
    return failed(fmt::format("cannot make a socket: {}", std::strerror(errno)));
  }
  const auto pid = spawn(task.program, sockets[1]);
  close(sockets[1]);
  if (!pid) {
    close(sockets[0]);
    return tl::unexpected(pid.error());
  }
  std::unique_ptr<Apart> apart(new Apart(std::move(task), *pid, sockets[0]));
  apart->on_end_ = std::move(ended);
  apart->thread_ = std::thread([raw = apart.get()] { raw->run(); });
  return apart;
}

Apart::~Apart() {
  kill(pid_, SIGKILL);  // a zombie until the thread has waited for it, so the number is still its own
  thread_.join();
  waitpid(pid_, nullptr, 0);
  close(socket_);
}

void Apart::run() {
  const auto begin = std::chrono::steady_clock::now();
  ByteWriter head;
  head.put(static_cast<std::uint8_t>(task_.work == WorkKind::evolve));
  head.put(static_cast<std::uint64_t>(task_.chain_bytes.size()));
  const bool sent = send_all(socket_, head.take()) && send_all(socket_, task_.chain_bytes) &&
                    send_all(socket_, task_.payload) && shutdown(socket_, SHUT_WR) == 0;
  Ended ended;
  ended.answer = receive_all(socket_);
  siginfo_t info{};
  while (waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOWAIT) != 0 && errno == EINTR) {
  }
  if (info.si_code != CLD_EXITED) {
    ended.died = fmt::format("process {} was killed by signal {}", pid_, info.si_status);
  } else if (info.si_status != 0 || !sent) {
    ended.died = fmt::format("process {} exited with code {}", pid_, info.si_status);
  }
  ended.elapsed = std::chrono::steady_clock::now() - begin;
  {
    const std::lock_guard lock(mutex_);
    ended_ = std::move(ended);
  }
  on_end_();
}

std::optional<Apart::Ended> Apart::take_ended() {
  const std::lock_guard lock(mutex_);
  return std::exchange(ended_, std::nullopt);
}

}  // namespace coppice
