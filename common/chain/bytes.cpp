#include "common/chain/bytes.hpp"

#include "common/check.hpp"

namespace coppice {

void ByteWriter::put_text(std::string_view text) {
  COPPICE_CHECK(text.size() < (std::size_t{1} << 16U));
  put(static_cast<std::uint16_t>(text.size()));
  bytes_.insert(bytes_.end(), text.begin(), text.end());
}

std::string ByteReader::get_text() {
  const auto length = get<std::uint16_t>();
  const std::vector<char> characters = get_all<char>(length);
  return {characters.begin(), characters.end()};
}

}  // namespace coppice
