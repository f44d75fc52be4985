#include "coordinator/runs/tree_of_study.hpp"

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <system_error>
#include <vector>

#include "common/tree/text.hpp"
#include "coordinator/exchange/behavior_tree_reader.hpp"
#include "coordinator/exchange/tree_file.hpp"
#include "coordinator/exchange/tree_json.hpp"
#include "coordinator/runs/tree_lines.hpp"

namespace coppice {
namespace {

constexpr std::size_t kHead = 4096;  // bytes of a file that are looked at to tell its form

Result<Tree> tree_in_file(const std::string& path, const Vocabulary& vocabulary) {
  std::filebuf in;
  if (in.open(path, std::ios::in) == nullptr) {
    return failed(fmt::format("cannot read {}: {}", path, std::generic_category().message(errno)));
  }
  // As far as it takes to tell the form, then from the start again.
  std::string content(kHead, '\0');
  content.resize(static_cast<std::size_t>(in.sgetn(content.data(), static_cast<std::streamsize>(content.size()))));
  if (tree_form(content) != TreeForm::text) {
    constexpr std::size_t kMost = std::max(kMaxTreeJson, kMaxBehaviorTreeXml) + 1;  // one more: it is refused, then
    const std::size_t read = content.size();
    content.resize(kMost);
    content.resize(
        read + static_cast<std::size_t>(in.sgetn(content.data() + read, static_cast<std::streamsize>(kMost - read))));
    return parse_tree_document(content, path, vocabulary);
  }
  in.pubseekpos(0, std::ios::in);
  TreeLines lines(in, path, vocabulary);
  std::optional<Tree> tree;
  // Ends with the file: every turn consumes a line.
  while (true) {
    const Result<TreeLines::Event> event = lines.next();
    if (!event) {
      return tl::unexpected(event.error());
    }
    if (*event == TreeLines::Event::end) {
      break;
    }
    if (*event == TreeLines::Event::tree) {
      if (tree) {
        return bad_input(fmt::format("{}: holds more than one tree: expected one", path));
      }
      tree = lines.tree();
    }
  }
  if (!tree) {
    return bad_input(fmt::format("{}: holds no tree: expected one", path));
  }
  return *tree;
}

// The last finished run, else the last that has a tree.
Result<std::optional<RunRecord>> last_run(const Study& study) {
  const Result<std::vector<RunRecord>> runs = study.runs();
  if (!runs) {
    return tl::unexpected(runs.error());
  }
  for (auto run = runs->rbegin(); run != runs->rend(); ++run) {
    if (run->status == RunStatus::finished) {
      return *run;
    }
  }
  for (auto run = runs->rbegin(); run != runs->rend(); ++run) {
    if (run->tree || run->generations > 0) {
      return *run;
    }
  }
  return std::nullopt;
}

}  // namespace

Result<Tree> tree_of_run(const Study& study, std::optional<RunId> run) {
  if (run) {
    return study.best_tree(*run);
  }
  const Result<std::optional<RunRecord>> last = last_run(study);
  if (!last) {
    return tl::unexpected(last.error());
  }
  if (!*last) {
    return bad_input(
        fmt::format("{}: has no run with a tree yet: expected --tree, or run 'coppice evolve' first", study.path()));
  }
  return study.best_tree((*last)->id);
}

Result<std::optional<EvolveConfig>> config_of_run(const Study& study, std::optional<RunId> run) {
  if (run) {
    return study.run(*run).map([](const RunRecord& record) { return std::optional(record.config); });
  }
  return last_run(study).map(
      [](const std::optional<RunRecord>& last) { return last ? std::optional(last->config) : std::nullopt; });
}

Result<Tree> tree_of_text_or_file(const Study& study, const std::string& text) {
  std::error_code error;  // a long tree is no valid file name: not a file, then
  if (std::filesystem::is_regular_file(text, error)) {
    return tree_in_file(text, study.chain().vocabulary());
  }
  Result<Tree> tree = parse_tree(text, study.chain().vocabulary());
  if (!tree) {
    return in_context("--tree (no file of that name, so read as a tree)", std::move(tree).error());
  }
  return tree;
}

}  // namespace coppice
