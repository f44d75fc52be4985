// slow_link A B MILLISECONDS: carries every packet between two network interfaces, that much later, until it is
// killed. Stands in for tc netem, which many kernels lack. Needs root.
#include <arpa/inet.h>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <linux/if_packet.h>
#include <net/ethernet.h>
#include <net/if.h>
#include <poll.h>
#include <sys/socket.h>
#include <vector>

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kLargestPacket = 70'000;
constexpr std::size_t kMostWaiting = 100'000;  // packets; what comes on top is lost, as on any link
constexpr int kMostPerTurn = 64;

struct Packet {
  Clock::time_point due;
  std::vector<char> bytes;
};

int fail(const char* what) {
  std::perror(what);
  return 1;
}

int open_end(const char* name) {
  const int end = socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC, htons(ETH_P_ALL));
  sockaddr_ll address{};
  address.sll_family = AF_PACKET;
  address.sll_protocol = htons(ETH_P_ALL);
  address.sll_ifindex = static_cast<int>(if_nametoindex(name));
  const int incoming_only = 1;
  const int buffer = 64 << 20;
  setsockopt(end, SOL_SOCKET, SO_RCVBUFFORCE, &buffer, sizeof buffer);
  if (end < 0 || address.sll_ifindex == 0 ||
      setsockopt(end, SOL_PACKET, PACKET_IGNORE_OUTGOING, &incoming_only, sizeof incoming_only) != 0 ||
      bind(end, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    return -1;
  }
  return end;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fputs("usage: slow_link A B MILLISECONDS\n", stderr);
    return 2;
  }
  const std::array<int, 2> ends = {open_end(argv[1]), open_end(argv[2])};
  if (ends[0] < 0 || ends[1] < 0) {
    return fail("slow_link: cannot open both interfaces");
  }
  const std::chrono::milliseconds delay(std::strtol(argv[3], nullptr, 10));
  std::array<std::deque<Packet>, 2> waiting;
  std::vector<char> buffer(kLargestPacket);
  std::puts("relaying");
  std::fflush(stdout);
  while (true) {
    auto next = Clock::now() + std::chrono::seconds(1);
    for (const auto& queue : waiting) {
      next = queue.empty() ? next : std::min(next, queue.front().due);
    }
    const auto pause = std::max<std::chrono::nanoseconds>(next - Clock::now(), std::chrono::nanoseconds(0));
    const timespec time{pause.count() / 1'000'000'000, pause.count() % 1'000'000'000};
    std::array<pollfd, 2> sources = {{{ends[0], POLLIN, 0}, {ends[1], POLLIN, 0}}};
    if (ppoll(sources.data(), sources.size(), &time, nullptr) < 0) {
      return fail("slow_link: ppoll");
    }
    for (std::size_t from = 0; from < 2; ++from) {
      for (int i = 0; i < kMostPerTurn; ++i) {
        const ssize_t size = recv(ends[from], buffer.data(), buffer.size(), MSG_DONTWAIT);
        if (size <= 0) {
          break;
        }
        if (waiting[from].size() < kMostWaiting) {
          waiting[from].push_back({Clock::now() + delay, {buffer.begin(), buffer.begin() + size}});
        }
      }
    }
    for (std::size_t from = 0; from < 2; ++from) {
      while (!waiting[from].empty() && waiting[from].front().due <= Clock::now()) {
        const Packet& packet = waiting[from].front();
        send(ends[1 - from], packet.bytes.data(), packet.bytes.size(), 0);  // what does not go out is lost
        waiting[from].pop_front();
      }
    }
  }
}
