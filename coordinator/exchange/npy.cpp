#include "coordinator/exchange/npy.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <fmt/format.h>
#include <fstream>
#include <limits>
#include <optional>

#include "coordinator/exchange/line_reader.hpp"
#include "coordinator/exchange/text_number.hpp"

namespace coppice {
namespace {

constexpr std::string_view kMagic("\x93NUMPY", 6);
constexpr std::size_t kMaxHeader = 65536;  // bytes
constexpr std::size_t kMaxDimensions = 32;

static_assert(std::endian::native == std::endian::little, "arrays are copied byte by byte");

struct Header {
  std::string type;
  bool fortran = false;
  std::vector<std::size_t> shape;
};

// What stands behind 'key': in a Python dictionary literal, up to the comma or brace that ends it.
std::optional<std::string_view> value_behind(std::string_view text, std::string_view key) {
  const std::size_t at = text.find(key);
  if (at == std::string_view::npos) {
    return std::nullopt;
  }
  text.remove_prefix(at + key.size());
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos) {
    return std::nullopt;
  }
  text = trimmed(text.substr(colon + 1));
  if (!text.empty() && text.front() == '(') {
    const std::size_t end = text.find(')');
    return end == std::string_view::npos ? std::nullopt : std::optional(text.substr(1, end - 1));
  }
  return trimmed(text.substr(0, text.find_first_of(",}")));
}

std::optional<Header> header_of(std::string_view text) {
  const auto type = value_behind(text, "'descr'");
  const auto order = value_behind(text, "'fortran_order'");
  auto shape = value_behind(text, "'shape'");
  if (!type || !order || !shape || type->size() < 4 || (*order != "True" && *order != "False")) {
    return std::nullopt;
  }
  Header header{std::string(type->substr(1, type->size() - 2)), *order == "True", {}};
  while (!trimmed(*shape).empty()) {  // ends: every turn takes a number away
    const std::size_t comma = shape->find(',');
    const auto size = to_whole(trimmed(shape->substr(0, comma)));
    if (!size || header.shape.size() == kMaxDimensions) {
      return std::nullopt;
    }
    header.shape.push_back(*size);
    shape->remove_prefix(comma == std::string_view::npos ? shape->size() : comma + 1);
  }
  return header;
}

template <typename T>
double number_at(const char* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return static_cast<double>(value);
}

struct Type {
  std::string_view name;
  std::size_t size;
  double (*read)(const char*);
};
constexpr std::array<Type, 12> kTypes{{{"<f8", 8, number_at<double>},
                                       {"<f4", 4, number_at<float>},
                                       {"<i8", 8, number_at<std::int64_t>},
                                       {"<i4", 4, number_at<std::int32_t>},
                                       {"<i2", 2, number_at<std::int16_t>},
                                       {"|i1", 1, number_at<std::int8_t>},
                                       {"<u8", 8, number_at<std::uint64_t>},
                                       {"<u4", 4, number_at<std::uint32_t>},
                                       {"<u2", 2, number_at<std::uint16_t>},
                                       {"|u1", 1, number_at<std::uint8_t>},
                                       {"|b1", 1, number_at<std::uint8_t>},
                                       {"<b1", 1, number_at<std::uint8_t>}}};

std::vector<double> in_c_order(const std::vector<double>& values, const std::vector<std::size_t>& shape) {
  std::vector<double> result(values.size());
  std::vector<std::size_t> index(shape.size(), 0);
  for (const double value : values) {
    std::size_t place = 0;
    for (std::size_t d = 0; d < shape.size(); ++d) {
      place = place * shape[d] + index[d];
    }
    result[place] = value;
    for (std::size_t d = 0; d < shape.size() && ++index[d] == shape[d]; ++d) {
      index[d] = 0;
    }
  }
  return result;
}

}  // namespace

bool is_npy(std::string_view first_bytes) { return first_bytes.substr(0, kMagic.size()) == kMagic; }

Result<NumberArray> read_npy(const std::string& path) {
  if (const auto readable = first_bytes(path, 1); !readable) {
    return tl::unexpected(readable.error());
  }
  std::ifstream file(path, std::ios::binary);
  const auto wrong = [&path](const std::string& what) { return bad_input(fmt::format("{}: {}", path, what)); };
  std::array<char, 12> start{};
  file.read(start.data(), 8);
  if (!file || !is_npy({start.data(), 8}) || start[6] < 1 || start[6] > 3) {
    return wrong("no .npy file of format 1 to 3");
  }
  const std::size_t length_size = start[6] == 1 ? 2 : 4;
  file.read(start.data() + 8, static_cast<std::streamsize>(length_size));
  std::uint32_t length = 0;
  std::memcpy(&length, start.data() + 8, length_size);
  if (!file || length > kMaxHeader) {
    return wrong(fmt::format("a header of {} bytes: expected at most {}", length, kMaxHeader));
  }
  std::string text(length, '\0');
  file.read(text.data(), static_cast<std::streamsize>(length));
  const auto header = file ? header_of(text) : std::nullopt;
  if (!header) {
    return wrong("the header is not that of a NumPy array: expected descr, fortran_order and shape");
  }
  const auto* type =
      std::find_if(kTypes.begin(), kTypes.end(), [&](const Type& known) { return known.name == header->type; });
  if (type == kTypes.end()) {
    return wrong(fmt::format("an array of type '{}': expected little-endian numbers (<f8, <i8, ...)", header->type));
  }
  NumberArray array{header->shape, {}};
  std::size_t entries = 1;
  for (const std::size_t size : array.shape) {
    if (size == 0 || entries > kMaxArrayEntries / size) {
      return wrong(fmt::format("shape ({}): expected 1 to {} entries", fmt::join(array.shape, ", "), kMaxArrayEntries));
    }
    entries *= size;
  }
  if (array.shape.empty()) {
    return wrong("a single number: expected an array");
  }
  // Read in pieces, so that memory is taken only for what is there.
  constexpr std::size_t kPiece = std::size_t{1} << 16U;
  std::vector<char> bytes(kPiece * type->size);
  while (array.values.size() < entries) {
    const std::size_t count = std::min(kPiece, entries - array.values.size());
    file.read(bytes.data(), static_cast<std::streamsize>(count * type->size));
    if (!file) {
      return wrong(fmt::format("cut short: expected {} entries", entries));
    }
    for (std::size_t i = 0; i < count; ++i) {
      array.values.push_back(type->read(bytes.data() + i * type->size));
    }
  }
  if (file.get() != std::ifstream::traits_type::eof()) {
    return wrong(fmt::format("foreign bytes behind {} entries", entries));
  }
  if (header->fortran && array.shape.size() > 1) {
    array.values = in_c_order(array.values, array.shape);
  }
  return array;
}

}  // namespace coppice
