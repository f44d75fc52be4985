// A target with a bug, to see that the driver finds it and shows the input: two '(' of different depth side by side.
#include "common/check.hpp"
#include "tests/fuzz/target.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto text = coppice::fuzz::as_text(data, size);
  coppice::fuzz::accepted = text.find('(') != text.npos;
  COPPICE_CHECK(text.find("((") == text.npos);
  return 0;
}
