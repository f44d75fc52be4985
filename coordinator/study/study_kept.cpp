// Trees that a person keeps in a study, with a name and a note. The table is made with the first of them, so that
// programs that know nothing of it read the study as before.
#include <ctime>
#include <fmt/format.h>

#include "common/tree/text.hpp"
#include "coordinator/study/database.hpp"
#include "coordinator/study/study_state.hpp"

namespace coppice {
namespace {

constexpr const char* kKeptTable = R"(
CREATE TABLE IF NOT EXISTS kept_trees(
  id   INTEGER PRIMARY KEY AUTOINCREMENT,
  name TEXT NOT NULL,
  note TEXT NOT NULL,
  tree TEXT NOT NULL,
  kept TEXT NOT NULL                -- UTC
) STRICT;
)";

bool has_table(SQLite::Database& database) { return database.tableExists("kept_trees"); }

Result<void> check_text(std::string_view what, const std::string& text, std::size_t most) {
  if (text.size() > most) {
    return bad_input(fmt::format("the {} has {} characters: at most {} are kept", what, text.size(), most));
  }
  return {};
}

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  static_cast<void>(gmtime_r(&now, &parts));
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z", parts.tm_year + 1900, parts.tm_mon + 1, parts.tm_mday,
                     parts.tm_hour, parts.tm_min, parts.tm_sec);
}

}  // namespace

Result<std::int64_t> Study::keep_tree(const std::string& name, const std::string& note, const Tree& tree) {
  if (name.empty()) {
    return bad_input("a tree that is kept needs a name");
  }
  if (const auto checked = check_text("name", name, kMaxKeptName); !checked) {
    return tl::unexpected(checked.error());
  }
  if (const auto checked = check_text("note", note, kMaxKeptNote); !checked) {
    return tl::unexpected(checked.error());
  }
  return guarded(state_->path, [&]() -> Result<std::int64_t> {
    SQLite::Transaction transaction(state_->database, SQLite::TransactionBehavior::IMMEDIATE);
    state_->database.exec(kKeptTable);
    SQLite::Statement insert(state_->database, "INSERT INTO kept_trees(name, note, tree, kept) VALUES(?, ?, ?, ?)");
    insert.bind(1, name);
    insert.bind(2, note);
    insert.bind(3, to_text(tree, chain().vocabulary()));
    insert.bind(4, utc_now());
    insert.exec();
    const std::int64_t id = state_->database.getLastInsertRowid();
    transaction.commit();
    return state_->check_in_place().map([id] { return id; });
  });
}

Result<void> Study::forget_tree(std::int64_t id) {
  return guarded(state_->path, [&]() -> Result<void> {
    if (!has_table(state_->database)) {
      return bad_input(fmt::format("{}: keeps no tree of number {}", state_->path, id));
    }
    SQLite::Statement remove(state_->database, "DELETE FROM kept_trees WHERE id = ?");
    remove.bind(1, id);
    if (remove.exec() == 0) {
      return bad_input(fmt::format("{}: keeps no tree of number {}", state_->path, id));
    }
    return state_->check_in_place();
  });
}

Result<std::vector<KeptTree>> Study::kept_trees() const {
  return guarded(state_->path, [&]() -> Result<std::vector<KeptTree>> {
    std::vector<KeptTree> kept;
    if (!has_table(state_->database)) {
      return kept;
    }
    SQLite::Statement select(state_->database, "SELECT id, name, note, tree, kept FROM kept_trees ORDER BY id");
    while (select.executeStep()) {
      const std::int64_t id = select.getColumn(0).getInt64();
      auto tree = parse_tree(select.getColumn(3).getString(), chain().vocabulary());
      if (!tree) {
        return tl::unexpected(damaged(state_->path, fmt::format("kept tree {}: {}", id, tree.error().message)));
      }
      kept.push_back({.id = id,
                      .name = select.getColumn(1).getString(),
                      .note = select.getColumn(2).getString(),
                      .tree = std::move(*tree),
                      .kept = select.getColumn(4).getString()});
    }
    return kept;
  });
}

Result<std::int64_t> Study::changes_by_others() const {
  return guarded(state_->path, [&]() -> Result<std::int64_t> {
    SQLite::Statement version(state_->database, "PRAGMA data_version");
    version.executeStep();
    return version.getColumn(0).getInt64();
  });
}

}  // namespace coppice
