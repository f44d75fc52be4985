// Little-endian bytes: the writer that all our encodings share, and a reader that never reads past the end and
// never allocates more than the bytes at hand can fill. A reader that failed once stays failed and yields zeros, so
// a decoder checks ok() once per group of fields instead of at every field.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace coppice {

static_assert(std::endian::native == std::endian::little, "the encodings are copied byte by byte");

class ByteWriter {
 public:
  template <typename T>
  void put(T value) {
    static_assert(std::is_trivially_copyable_v<T>);
    const std::size_t at = bytes_.size();
    bytes_.resize(at + sizeof(T));
    std::memcpy(bytes_.data() + at, &value, sizeof(T));
  }
  template <typename T>
  void put_all(const std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    const std::size_t at = bytes_.size();
    bytes_.resize(at + values.size() * sizeof(T));
    if (!values.empty()) {
      std::memcpy(bytes_.data() + at, values.data(), values.size() * sizeof(T));
    }
  }
  // Length (16 bits), then the characters. REQUIRES: text.size() < 2^16.
  void put_text(std::string_view text);

  void reserve(std::size_t size) { bytes_.reserve(size); }
  const std::vector<std::uint8_t>& bytes() const { return bytes_; }
  std::vector<std::uint8_t> take() { return std::move(bytes_); }

 private:
  std::vector<std::uint8_t> bytes_;
};

class ByteReader {
 public:
  explicit ByteReader(std::span<const std::uint8_t> bytes) : rest_(bytes), left_(bytes.size()) {}
  // `size` bytes in pieces: `next` gives the first, and the following one whenever the one before was read to its end
  // (which it may then free).
  using NextPiece = std::function<std::span<const std::uint8_t>()>;
  ByteReader(std::size_t size, NextPiece next) : left_(size), next_(std::move(next)) {}

  template <typename T>
  T get() {
    static_assert(std::is_trivially_copyable_v<T>);
    T value{};
    if (left_ < sizeof(T)) {
      fail();
      return value;
    }
    copy_to(&value, sizeof(T));
    return value;
  }
  template <typename T>
  std::vector<T> get_all(std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (count > left_ / sizeof(T)) {
      fail();
      return {};
    }
    // Little by little, so that memory is taken no sooner than the pieces that were read are freed.
    constexpr std::size_t kMostAtOnce = std::size_t{1} << 16U;
    std::vector<T> values;
    values.reserve(count);
    while (values.size() < count) {
      const std::size_t read = values.size();
      const std::size_t more = std::min(kMostAtOnce, count - read);
      values.resize(read + more);
      copy_to(values.data() + read, more * sizeof(T));
    }
    return values;
  }
  std::string get_text();

  bool ok() const { return ok_; }
  std::size_t left() const { return left_; }

 private:
  void fail() {
    ok_ = false;
    rest_ = {};
    left_ = 0;
  }
  // REQUIRES: size <= left_.
  void copy_to(void* out, std::size_t size) {
    if (size > rest_.size()) [[unlikely]] {
      copy_pieces(static_cast<std::uint8_t*>(out), size);
      return;
    }
    std::memcpy(out, rest_.data(), size);
    rest_ = rest_.subspan(size);
    left_ -= size;
  }
  void copy_pieces(std::uint8_t* out, std::size_t size);

  std::span<const std::uint8_t> rest_;  // of the piece at hand
  std::size_t left_ = 0;                // in all
  NextPiece next_;
  bool ok_ = true;
};

}  // namespace coppice
