#include "coordinator/fleet/port_holder.hpp"

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace coppice {
namespace {

TEST(PortHolder, IsTheProcessThatBoundThePortAndNobodyAfterwards) {
  const int socket_fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  socklen_t length = sizeof address;
  ASSERT_EQ(bind(socket_fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  ASSERT_EQ(getsockname(socket_fd, reinterpret_cast<sockaddr*>(&address), &length), 0);
  const std::uint32_t port = ntohs(address.sin_port);
  const auto holder = udp_port_holder(port);
  close(socket_fd);
  ASSERT_TRUE(holder.has_value());
  EXPECT_EQ(holder->pid, getpid());
  EXPECT_NE(holder->command.find("fleet_test"), std::string::npos) << holder->command;
  EXPECT_FALSE(udp_port_holder(port).has_value());
}

}  // namespace
}  // namespace coppice
