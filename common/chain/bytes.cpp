#include "common/chain/bytes.hpp"

#include "common/check.hpp"

namespace coppice {

void ByteWriter::put_text(std::string_view text) {
  COPPICE_CHECK(text.size() < (std::size_t{1} << 16U));
  put(static_cast<std::uint16_t>(text.size()));
  bytes_.insert(bytes_.end(), text.begin(), text.end());
}

void ByteReader::copy_pieces(std::uint8_t* out, std::size_t size) {
  left_ -= size;
  while (size > 0) {
    if (rest_.empty()) {
      COPPICE_CHECK(next_ != nullptr);
      rest_ = next_();
      COPPICE_CHECK(!rest_.empty());
    }
    const std::size_t count = std::min(size, rest_.size());
    std::memcpy(out, rest_.data(), count);
    rest_ = rest_.subspan(count);
    out += count;
    size -= count;
  }
}

std::string ByteReader::get_text() {
  const auto length = get<std::uint16_t>();
  const std::vector<char> characters = get_all<char>(length);
  return {characters.begin(), characters.end()};
}

}  // namespace coppice
