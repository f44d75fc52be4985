// Runs a fuzz target without libFuzzer: every file of its corpus, which must be accepted or, where the name begins with
// "bad", refused; then a given number of inputs near the corpus (mutation.hpp), some of which must be accepted. Fails
// by exit code 1, or as the target does, having shown the input (last_input.hpp).
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "tests/fuzz/last_input.hpp"
#include "tests/fuzz/mutation.hpp"
#include "tests/fuzz/target.hpp"

namespace coppice::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t kMaxInputs = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint32_t kBlock = 4096;  // inputs between two signs of progress

struct File {
  std::string path;
  Bytes bytes;
  bool is_bad() const { return fs::path(path).filename().string().rfind("bad", 0) == 0; }
};

struct Options {
  std::vector<std::string> paths;
  std::uint32_t inputs = 0;
  std::uint32_t seed = 1;
  std::optional<std::uint32_t> only;
  std::string save;
};

std::vector<File> read_files(const std::vector<std::string>& paths) {
  std::vector<std::string> names;
  for (const std::string& path : paths) {
    if (!fs::is_directory(path)) {
      names.push_back(path);
      continue;
    }
    for (const auto& entry : fs::directory_iterator(path)) {
      names.push_back(entry.path().string());
    }
  }
  std::sort(names.begin(), names.end());  // input i must not depend on the order of a directory
  std::vector<File> files;
  for (const std::string& name : names) {
    std::ifstream stream(name, std::ios::binary);
    if (!stream) {
      throw std::runtime_error(name + ": cannot be read");
    }
    files.push_back({name, Bytes(std::istreambuf_iterator<char>(stream), {})});
  }
  if (files.empty()) {
    throw std::runtime_error("no files: expected a corpus");
  }
  return files;
}

// An exception ends the program where it is thrown, as under libFuzzer.
void call_target(const std::uint8_t* data, std::size_t size) noexcept { LLVMFuzzerTestOneInput(data, size); }

// In memory of exactly its size, so that a sanitizer sees a read past the end. Whether the target accepted it.
bool run(const std::string& origin, const Bytes& input) {
  const std::unique_ptr<std::uint8_t[]> exact(new std::uint8_t[input.size()]);
  std::copy(input.begin(), input.end(), exact.get());
  set_last_input(origin, exact.get(), input.size());
  accepted = false;
  call_target(exact.get(), input.size());
  forget_last_input();
  return accepted;
}

bool run_files(const std::vector<File>& files) {
  bool good = true;
  for (const File& file : files) {
    expect_progress();
    if (run(file.path, file.bytes) == file.is_bad()) {
      fmt::print(stderr, "{}: {}\n", file.path,
                 file.is_bad() ? "accepted, though its name begins with 'bad'"
                               : "refused: expected it to be accepted, or a name that begins with 'bad'");
      good = false;
    }
  }
  return good;
}

bool run_mutations(const Mutation& mutation, const Options& options) {
  using Seconds = std::chrono::duration<double>;
  const auto begin = std::chrono::steady_clock::now();
  std::uint32_t accepted_inputs = 0;
  Bytes input;
  std::string origin;
  for (std::uint32_t i = 0; i < options.inputs; ++i) {
    if (i % kBlock == 0) {
      expect_progress();
    }
    mutation.make(i, input);
    origin.clear();
    fmt::format_to(std::back_inserter(origin), "input {} (--seed {} --only {})", i, options.seed, i);
    accepted_inputs += run(origin, input) ? 1 : 0;
  }
  const double seconds = Seconds(std::chrono::steady_clock::now() - begin).count();
  fmt::print("{} inputs of seed {}: {} accepted; {:.0f} inputs/s\n", options.inputs, options.seed, accepted_inputs,
             options.inputs / std::max(seconds, 1e-9));
  if (accepted_inputs == 0) {
    fmt::print(stderr, "none was accepted: expected some, or only the first lines of the parser are tested\n");
  }
  return accepted_inputs > 0;
}

void run_only(const Mutation& mutation, std::uint32_t i, const std::string& save) {
  Bytes input;
  mutation.make(i, input);
  if (!save.empty()) {
    std::ofstream(save, std::ios::binary)
        .write(reinterpret_cast<const char*>(input.data()), static_cast<std::streamsize>(input.size()));
  }
  expect_progress();
  const bool was_accepted = run(fmt::format("input {}", i), input);
  fmt::print("input {}, {} bytes: {}\n", i, input.size(), was_accepted ? "accepted" : "refused");
}

int drive(const Options& options) {
  const std::vector<File> files = read_files(options.paths);
  Corpus corpus;
  for (const File& file : files) {
    (file.is_bad() ? corpus.bad : corpus.good).push_back(file.bytes);
  }
  const Mutation mutation(std::move(corpus), options.seed);
  show_last_input_when_stopped();
  if (options.only) {
    run_only(mutation, *options.only, options.save);
    return 0;
  }
  const bool good = run_files(files);
  fmt::print("{} files\n", files.size());
  return (options.inputs == 0 || run_mutations(mutation, options)) && good ? 0 : 1;
}

}  // namespace
}  // namespace coppice::fuzz

int main(int argc, char** argv) {
  coppice::fuzz::Options options;
  CLI::App app(
      "Runs a fuzz target over a corpus, then over inputs near it.\n"
      "Example: tree_text_fuzz_test tests/fuzz/corpus/tree_text --inputs 100000 --seed 7");
  app.add_option("paths", options.paths, "Corpus: files, or folders of them")->required()->check(CLI::ExistingPath);
  const CLI::Range numbers(std::uint32_t{0}, coppice::fuzz::kMaxInputs);
  app.add_option("--inputs", options.inputs, "How many inputs near the corpus")->check(numbers);
  app.add_option("--seed", options.seed, "Which ones")->capture_default_str()->check(numbers);
  auto* only = app.add_option("--only", options.only, "Run this one of them, and nothing else")->check(numbers);
  app.add_option("--save", options.save, "A file to write that one to, before it runs")->needs(only);
  CLI11_PARSE(app, argc, argv);
  try {
    return coppice::fuzz::drive(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
