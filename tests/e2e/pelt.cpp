// Pelts UDP ports with datagrams of nonsense (datagrams.hpp), for the tests:
//   pelt SEED SECONDS ADDRESS:PORT...
// It says that it is a participant, so that whoever believes it sends packets, which come back changed. When the time
// is over it says how many went out and came in.
#include <arpa/inet.h>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <netinet/in.h>
#include <string>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include "tests/e2e/datagrams.hpp"

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kAnnounceInterval{500};
constexpr std::chrono::microseconds kRest{50};  // between two, so that those who belong get a word in

sockaddr_in address_of(const std::string& text) {
  const std::size_t colon = text.find(':');
  sockaddr_in address{};
  address.sin_family = AF_INET;
  if (colon == std::string::npos || inet_pton(AF_INET, text.substr(0, colon).c_str(), &address.sin_addr) != 1) {
    std::fprintf(stderr, "pelt: '%s': expected ADDRESS:PORT\n", text.c_str());
    std::exit(2);
  }
  address.sin_port = htons(static_cast<std::uint16_t>(std::strtoul(text.c_str() + colon + 1, nullptr, 10)));
  return address;
}

const sockaddr* generic(const sockaddr_in& address) { return reinterpret_cast<const sockaddr*>(&address); }

// Where packets from there come to.
std::string announcement(const coppice::e2e::Datagrams& datagrams, int socket_fd, const sockaddr_in& there) {
  sockaddr_in own{};
  socklen_t length = sizeof own;
  getsockname(socket_fd, reinterpret_cast<sockaddr*>(&own), &length);
  const std::uint16_t port = ntohs(own.sin_port);
  const int probe = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (connect(probe, generic(there), sizeof there) == 0) {
    getsockname(probe, reinterpret_cast<sockaddr*>(&own), &length);
  }
  close(probe);
  return datagrams.announcement(ntohl(own.sin_addr.s_addr), port);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fputs("usage: pelt SEED SECONDS ADDRESS:PORT...\n", stderr);
    return 2;
  }
  coppice::e2e::Datagrams datagrams(static_cast<std::uint32_t>(std::strtoul(argv[1], nullptr, 10)));
  const auto end = Clock::now() + std::chrono::duration<double>(std::strtod(argv[2], nullptr));
  std::vector<sockaddr_in> targets;
  for (int i = 3; i < argc; ++i) {
    targets.push_back(address_of(argv[i]));
  }
  const int socket_fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in any{};
  any.sin_family = AF_INET;
  if (bind(socket_fd, generic(any), sizeof any) != 0) {
    std::perror("pelt");
    return 1;
  }
  unsigned long out = 0;
  unsigned long in = 0;
  Clock::time_point next_announcement;
  for (Clock::time_point now = Clock::now(); now < end; now = Clock::now()) {
    if (now >= next_announcement) {
      next_announcement = now + kAnnounceInterval;
      for (const sockaddr_in& target : targets) {
        const std::string packet = announcement(datagrams, socket_fd, target);
        sendto(socket_fd, packet.data(), packet.size(), 0, generic(target), sizeof target);
      }
    }
    char heard[65536];
    for (ssize_t size = 0; (size = recv(socket_fd, heard, sizeof heard, MSG_DONTWAIT)) > 0; ++in) {
      datagrams.learn({heard, static_cast<std::size_t>(size)});
    }
    for (const sockaddr_in& target : targets) {
      const std::string packet = datagrams.next();
      out += sendto(socket_fd, packet.data(), packet.size(), 0, generic(target), sizeof target) >= 0 ? 1 : 0;
    }
    std::this_thread::sleep_for(kRest);
  }
  close(socket_fd);
  std::printf("threw %lu datagrams, heard %lu\n", out, in);
  return 0;
}
