// read_prism(): the files that stand beside one another, in one input: what follows a line `%% .sta` is the file of
// that extension, what comes before the first such line is the .tra. Whatever is accepted is a model.
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include "common/check.hpp"
#include "coordinator/exchange/prism.hpp"
#include "tests/fuzz/target.hpp"

namespace coppice::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 8> kBeside = {".sta",       ".lab",       ".srew",      ".trew",
                                                     ".gain.srew", ".cost.srew", ".gain.trew", ".cost.trew"};

// Made once, gone with the program.
class Folder {
 public:
  Folder() {
    std::string name = (fs::exists("/dev/shm") ? "/dev/shm" : fs::temp_directory_path().string()) + "/coppice_XXXXXX";
    COPPICE_CHECK(::mkdtemp(name.data()) != nullptr);
    path_ = name;
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  std::string file(std::string_view extension) const { return (path_ / ("model" + std::string(extension))).string(); }

 private:
  fs::path path_;
};

std::map<std::string, std::string> files_in(std::string_view bytes) {
  std::map<std::string, std::string> files;
  std::string extension = ".tra";
  while (!bytes.empty()) {  // ends: every turn takes a line
    const std::size_t end = bytes.find('\n');
    const std::string_view line = bytes.substr(0, end == std::string_view::npos ? bytes.size() : end + 1);
    bytes.remove_prefix(line.size());
    if (line.substr(0, 3) == "%% ") {
      extension = line.substr(3, line.find_last_not_of("\r\n") - 2);
    } else {
      files[extension] += line;
    }
  }
  return files;
}

void test(std::string_view bytes) {
  static const Folder kFolder;
  const std::map<std::string, std::string> files = files_in(bytes);
  const auto write = [&](std::string_view extension) {
    const auto found = files.find(std::string(extension));
    if (found == files.end()) {
      std::error_code ignored;
      fs::remove(kFolder.file(extension), ignored);
      return;
    }
    std::ofstream(kFolder.file(extension), std::ios::binary) << found->second;
  };
  write(".tra");
  if (files.count(".tra") == 0) {
    std::ofstream(kFolder.file(".tra"), std::ios::binary).flush();
  }
  for (const std::string_view extension : kBeside) {
    write(extension);
  }
  const auto model = read_prism(kFolder.file(".tra"));
  accepted = model.has_value();
  COPPICE_CHECK(model.has_value() ? check_model(*model).has_value() : is_refusal(model.error()));
}

}  // namespace
}  // namespace coppice::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  coppice::fuzz::test(coppice::fuzz::as_text(data, size));
  return 0;
}
