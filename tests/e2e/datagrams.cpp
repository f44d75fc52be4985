#include "tests/e2e/datagrams.hpp"

#include <algorithm>

namespace coppice::e2e {
namespace {

constexpr std::size_t kMostHeard = 512;
constexpr std::size_t kHeader = 20;  // RTPS: magic, version, vendor, prefix of the sender's identity
constexpr std::size_t kLargest = 1400;
constexpr std::string_view kMagic = "RTPS\2\1\1\x10";
constexpr std::uint32_t kSpdpWriter = 0x000100c2;
constexpr std::uint32_t kUdp4 = 1;

void put(std::string& out, std::uint32_t value, int bytes = 4) {
  for (int i = 0; i < bytes; ++i) {
    out.push_back(static_cast<char>(value >> (8 * i)));
  }
}

void put_entity(std::string& out, std::uint32_t id) {  // big-endian whatever the rest is
  for (int i = 3; i >= 0; --i) {
    out.push_back(static_cast<char>(id >> (8 * i)));
  }
}

void put_parameter(std::string& out, std::uint32_t id, std::string value) {
  value.resize((value.size() + 3) / 4 * 4);
  put(out, id, 2);
  put(out, static_cast<std::uint32_t>(value.size()), 2);
  out += value;
}

std::string framed(std::uint32_t kind, std::uint32_t flags, const std::string& body) {
  std::string out;
  put(out, kind, 1);
  put(out, flags, 1);
  put(out, static_cast<std::uint32_t>(body.size()), 2);
  return out + body;
}

}  // namespace

Datagrams::Datagrams(std::uint32_t seed) : random_(seed) {
  std::generate(own_.begin(), own_.end(), [this] { return static_cast<char>(random_()); });
}

void Datagrams::learn(std::string_view packet) {
  if (packet.size() < kHeader || !packet.starts_with("RTPS")) {
    return;
  }
  Prefix prefix;
  std::copy_n(packet.begin() + 8, prefix.size(), prefix.begin());
  if (std::find(prefixes_.begin(), prefixes_.end(), prefix) == prefixes_.end()) {
    prefixes_.push_back(prefix);
  }
  if (heard_.size() < kMostHeard) {
    heard_.emplace_back(packet);
  } else {
    heard_[below(kMostHeard)] = packet;
  }
}

std::string Datagrams::next() {
  switch (below(4)) {
    case 0:
      return noise(below(kLargest));
    case 1:
      return std::string(kMagic) + noise(below(kLargest));
    case 2:
      return heard_.empty() ? made_up() : changed(heard_[below(static_cast<std::uint32_t>(heard_.size()))]);
    default:
      return below(2) == 0 ? made_up() : changed(made_up());
  }
}

std::string Datagrams::noise(std::size_t size) {
  std::string bytes(size, '\0');
  std::generate(bytes.begin(), bytes.end(), [this] { return static_cast<char>(random_()); });
  return bytes;
}

// Sizes, counts and numbers where mistakes are made.
std::uint32_t Datagrams::wild() {
  constexpr std::array<std::uint32_t, 12> kEdges = {0,      1,      2,          3,          4,          255,
                                                    0x7fff, 0xffff, 0x10000000, 0x7fffffff, 0x80000000, 0xffffffff};
  return below(3) == 0 ? static_cast<std::uint32_t>(random_()) : kEdges[below(kEdges.size())];
}

std::uint32_t Datagrams::entity() {
  // Discovery, liveliness, handshakes and keys; the writers and readers of a program count up from 0x100.
  constexpr std::array<std::uint32_t, 14> kBuiltIn = {0,          0x000001c1, 0x000100c2, 0x000100c7, 0x000003c2,
                                                      0x000003c7, 0x000004c2, 0x000004c7, 0x000200c2, 0x000200c7,
                                                      0x000201c3, 0x000201c4, 0xff0202c3, 0xff0202c4};
  constexpr std::array<std::uint32_t, 4> kKinds = {0x02, 0x03, 0x04, 0x07};
  return below(2) == 0 ? kBuiltIn[below(kBuiltIn.size())] : below(64) << 8U | kKinds[below(kKinds.size())];
}

std::string Datagrams::parameters() {
  // Of topics, types, QoS, locators, identities, tokens, and one that ends the list.
  constexpr std::array<std::uint32_t, 22> kIds = {0x0002, 0x0005, 0x0007, 0x0015, 0x0016, 0x001a, 0x001d, 0x0029,
                                                  0x002c, 0x002f, 0x0031, 0x0032, 0x0050, 0x0058, 0x005a, 0x0062,
                                                  0x0070, 0x0071, 0x0072, 0x1001, 0x1002, 0x8000};
  std::string out;
  for (std::uint32_t i = below(8); i > 0; --i) {
    std::string value;
    for (std::uint32_t words = below(8); words > 0; --words) {
      put(value, wild());
    }
    if (below(4) == 0) {  // a text that says how long it is
      value.clear();
      put(value, below(2) == 0 ? 14 : wild());
      value += std::string("coppice_Hello\0", 14);
    }
    put_parameter(out, kIds[below(kIds.size())], value);
  }
  put(out, 1);  // the end
  return out;
}

std::string Datagrams::submessage() {
  constexpr std::array<std::uint32_t, 20> kKinds = {0x01, 0x06, 0x07, 0x08, 0x09, 0x0c, 0x0d, 0x0e, 0x0f, 0x12,
                                                    0x13, 0x15, 0x15, 0x15, 0x16, 0x30, 0x31, 0x32, 0x33, 0x34};
  const std::uint32_t kind = kKinds[below(kKinds.size())];
  std::string body;
  switch (kind) {
    case 0x15:  // a sample, or a piece of one
    case 0x16:
      put(body, 0, 2);
      put(body, below(8) == 0 ? wild() : kind == 0x15 ? 16 : 28, 2);
      put_entity(body, below(2) == 0 ? 0 : entity());
      put_entity(body, entity());
      put(body, below(4) == 0 ? wild() : 0);
      put(body, wild());
      if (kind == 0x16) {
        put(body, wild());
        put(body, wild(), 2);
        put(body, wild(), 2);
        put(body, wild());
      }
      body += std::string("\0\3\0\0", 4) + (below(4) == 0 ? noise(below(200)) : parameters());
      break;
    case 0x0e:  // to whom
      body = prefixes_.empty() ? noise(12)
                               : std::string(prefixes_[below(static_cast<std::uint32_t>(prefixes_.size()))].data(), 12);
      break;
    case 0x30:
    case 0x31:
    case 0x32:
    case 0x33:
    case 0x34:  // encrypted
      put(body, 2, 1);
      body += noise(below(3) == 0 ? below(64) : 19);
      put(body, wild());
      body += noise(below(64));
      break;
    default:  // heartbeats, acknowledgements, gaps, times, pieces that are missing
      put_entity(body, entity());
      put_entity(body, entity());
      for (std::uint32_t words = below(12); words > 0; --words) {
        put(body, wild());
      }
  }
  return framed(kind, below(8) == 0 ? below(256) : kind == 0x15 ? 5 : 1, body);
}

std::string Datagrams::made_up() {
  std::string out(kMagic);
  out += std::string(own_.data(), own_.size());
  for (std::uint32_t i = 1 + below(4); i > 0; --i) {
    out += submessage();
  }
  return out;
}

std::string Datagrams::changed(std::string packet) {
  for (std::uint32_t i = 1 + below(6); i > 0 && packet.size() > kHeader; --i) {
    const std::uint32_t at = below(static_cast<std::uint32_t>(packet.size()));
    std::string edge;
    put(edge, wild(), below(2) == 0 ? 2 : 4);
    switch (below(5)) {
      case 0:
        packet[at] = static_cast<char>(random_());
        break;
      case 1:
        packet.replace(at, std::min(edge.size(), packet.size() - at), edge);
        break;
      case 2:
        packet.resize(at);
        break;
      case 3:
        packet.insert(at, noise(below(16)));
        break;
      default:
        packet += packet.substr(std::min<std::size_t>(kHeader, packet.size()));  // twice
        packet.resize(std::min(packet.size(), kLargest));
    }
  }
  return packet;
}

std::string Datagrams::announcement(std::uint32_t address, std::uint16_t port) const {
  std::string locator;
  put(locator, kUdp4);
  put(locator, port);
  locator += std::string(12, '\0');
  put_entity(locator, address);
  std::string identity(own_.data(), own_.size());
  put_entity(identity, 0x000001c1);
  std::string lease;
  put(lease, 20);
  put(lease, 0);
  std::string endpoints;
  put(endpoints, 0xc3f);
  std::string parameters;
  put_parameter(parameters, 0x0015, std::string("\2\1", 2));
  put_parameter(parameters, 0x0016, std::string("\1\x10", 2));
  put_parameter(parameters, 0x0050, identity);
  put_parameter(parameters, 0x0058, endpoints);
  put_parameter(parameters, 0x0002, lease);
  put_parameter(parameters, 0x0031, locator);
  put_parameter(parameters, 0x0032, locator);
  put(parameters, 1);
  std::string body;
  put(body, 0, 2);
  put(body, 16, 2);
  put_entity(body, 0);
  put_entity(body, kSpdpWriter);
  put(body, 0);
  put(body, 1);
  body += std::string("\0\3\0\0", 4) + parameters;
  return std::string(kMagic) + std::string(own_.data(), own_.size()) + framed(0x15, 5, body);
}

}  // namespace coppice::e2e
