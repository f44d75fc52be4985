// NumPy's .npy files, in: arrays of numbers of any shape (format versions 1 to 3, little-endian, C or Fortran order).
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "common/error.hpp"

namespace coppice {

inline constexpr std::size_t kMaxArrayEntries = std::size_t{1} << 32U;

struct NumberArray {
  std::vector<std::size_t> shape;  // one entry or more
  std::vector<double> values;      // in C order, the last index fastest
};

bool is_npy(std::string_view first_bytes);

// Errors name the file, what was found and what was expected: foreign types (text, objects, complex), a file that is
// longer or shorter than its shape says.
Result<NumberArray> read_npy(const std::string& path);

}  // namespace coppice
