#include "coordinator/fleet/port_holder.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <pwd.h>
#include <sstream>
#include <vector>

namespace coppice {
namespace {

namespace fs = std::filesystem;

struct Socket {
  uid_t user = 0;
  std::string inode;
  bool ipv6 = false;
};

// A row of /proc/net/udp and of /proc/net/udp6 (proc(5)): sl, local address:port in hexadecimal, ..., uid, timeout,
// inode.
std::optional<Socket> socket_at(std::uint32_t port) {
  constexpr std::size_t kLocal = 1;
  constexpr std::size_t kUser = 7;
  constexpr std::size_t kInode = 9;
  const std::string suffix = fmt::format(":{:04X}", port);
  for (const bool ipv6 : {false, true}) {
    std::ifstream table(ipv6 ? "/proc/net/udp6" : "/proc/net/udp");
    for (std::string line; std::getline(table, line);) {
      std::istringstream stream(line);
      const std::vector<std::string> fields(std::istream_iterator<std::string>(stream), {});
      if (fields.size() > kInode && fields[kLocal].ends_with(suffix)) {
        Socket socket;
        std::from_chars(fields[kUser].data(), fields[kUser].data() + fields[kUser].size(), socket.user);
        socket.inode = fields[kInode];
        socket.ipv6 = ipv6;
        return socket;
      }
    }
  }
  return std::nullopt;
}

bool holds(const fs::path& process, const std::string& socket) {
  std::error_code error;
  for (fs::directory_iterator file(process / "fd", error), end; !error && file != end; file.increment(error)) {
    std::error_code gone;
    if (fs::read_symlink(file->path(), gone) == socket) {
      return true;
    }
  }
  return false;
}

std::string command_of(const fs::path& process) {
  std::ifstream file(process / "cmdline", std::ios::binary);
  std::string command(PortHolder::kMostCommand, '\0');
  file.read(command.data(), static_cast<std::streamsize>(command.size()));
  command.resize(static_cast<std::size_t>(file.gcount()));
  while (!command.empty() && command.back() == '\0') {
    command.pop_back();
  }
  std::replace(command.begin(), command.end(), '\0', ' ');
  return command;
}

std::string user_name(uid_t user) {
  const passwd* entry = getpwuid(user);
  return entry != nullptr ? entry->pw_name : std::to_string(user);
}

}  // namespace

std::optional<PortHolder> udp_port_holder(std::uint32_t port) {
  const auto socket = socket_at(port);
  if (!socket) {
    return std::nullopt;
  }
  PortHolder holder;
  holder.user = user_name(socket->user);
  holder.ipv6 = socket->ipv6;
  const std::string link = fmt::format("socket:[{}]", socket->inode);
  std::error_code error;
  for (fs::directory_iterator process("/proc", error), end; !error && process != end; process.increment(error)) {
    const std::string name = process->path().filename();
    pid_t pid = 0;
    const auto parsed = std::from_chars(name.data(), name.data() + name.size(), pid);
    if (parsed.ec == std::errc() && parsed.ptr == name.data() + name.size() && holds(process->path(), link)) {
      holder.pid = pid;
      holder.command = command_of(process->path());
      break;
    }
  }
  return holder;
}

std::string in_words(const PortHolder& holder) {
  return holder.pid ? fmt::format("pid {}, user {}: {}", *holder.pid, holder.user, holder.command)
                    : fmt::format("a process of user {}", holder.user);
}

}  // namespace coppice
