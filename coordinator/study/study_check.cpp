#include "coordinator/study/study_check.hpp"

#include <SQLiteCpp/SQLiteCpp.h>
#include <algorithm>
#include <fmt/format.h>

namespace coppice {
namespace {

constexpr int kMostFindings = 20;  // of the integrity check; more say no more

// What SQLite finds, besides what opening a study looks for: out-of-order rows, missing index entries.
void check_pages(const std::string& path, StudyCheck& check) {
  try {
    SQLite::Database database(path, SQLite::OPEN_READONLY);
    SQLite::Statement findings(database, fmt::format("PRAGMA integrity_check({})", kMostFindings));
    while (findings.executeStep()) {
      if (const std::string finding = findings.getColumn(0).getString(); finding != "ok") {
        check.damage.push_back(finding);
      }
    }
  } catch (const SQLite::Exception& exception) {
    check.damage.emplace_back(exception.what());
  }
}

// Of a study that cannot be opened: the trees as text, which need no chain to be of use.
void save_trees(const std::string& path, StudyCheck& check) {
  try {
    SQLite::Database database(path, SQLite::OPEN_READONLY);
    for (const char* query : {"SELECT DISTINCT tree FROM runs WHERE tree IS NOT NULL ORDER BY id",
                              "SELECT best_tree, max(best_fitness) AS best FROM generations GROUP BY best_tree ORDER "
                              "BY best DESC LIMIT 20"}) {
      SQLite::Statement rows(database, query);
      while (rows.executeStep()) {
        const std::string tree = rows.getColumn(0).getString();
        if (std::find(check.trees.begin(), check.trees.end(), tree) == check.trees.end()) {
          check.trees.push_back(tree);
        }
      }
    }
  } catch (const SQLite::Exception&) {  // NOLINT(bugprone-empty-catch)
    // What was read so far is what can be saved.
  }
}

template <typename T>
bool readable(const Result<T>& part, CheckedRun& run) {
  if (!part) {
    run.damage.push_back(part.error().message);
  }
  return part.has_value();
}

CheckedRun check_run(const Study& study, const RunRecord& record) {
  CheckedRun run;
  run.run = static_cast<std::int64_t>(record.id);
  run.status = std::string(name_of(record.status));
  const auto generations = study.generations(record.id);
  if (readable(generations, run)) {
    run.generations = static_cast<std::uint32_t>(generations->size());
  }
  const auto checkpoint = study.load_checkpoint(record.id);
  run.resumable = readable(checkpoint, run) && record.status != RunStatus::finished &&
                  (record.abandoned || record.status != RunStatus::running);
  readable(study.front(record.id), run);
  if (record.tree || record.generations > 0) {
    readable(study.best_tree(record.id), run);
  }
  return run;
}

}  // namespace

bool StudyCheck::whole() const {
  return damage.empty() &&
         std::all_of(runs.begin(), runs.end(), [](const CheckedRun& run) { return run.damage.empty(); });
}

Result<StudyCheck> check_study(const std::string& path) {
  StudyCheck check;
  const Result<Study> study = Study::open(path, Study::Access::read);
  if (!study) {
    if (study.error().message.find("damaged") == std::string::npos) {
      return tl::unexpected(study.error());
    }
    check.damage.push_back(study.error().message);
    check_pages(path, check);
    save_trees(path, check);
    return check;
  }
  check_pages(path, check);
  const auto runs = study->runs();
  if (!runs) {
    check.damage.push_back(runs.error().message);
    save_trees(path, check);
    return check;
  }
  for (const RunRecord& record : *runs) {
    check.runs.push_back(check_run(*study, record));
  }
  if (!check.whole()) {
    save_trees(path, check);
  }
  return check;
}

}  // namespace coppice
