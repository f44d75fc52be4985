// The fronts of a study: of each run that searched for one, its trees with what they were measured by.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/check.hpp"
#include "common/tree/text.hpp"
#include "coordinator/study/database.hpp"
#include "coordinator/study/study_rows.hpp"
#include "coordinator/study/study_state.hpp"

namespace coppice {

Result<void> Study::save_front(RunId run, const Front& front) {
  return guarded(state_->path, [&]() -> Result<void> {
    SQLite::Transaction transaction(state_->database, SQLite::TransactionBehavior::IMMEDIATE);
    SQLite::Statement remove(state_->database, "DELETE FROM fronts WHERE run = ?");
    remove.bind(1, number(run));
    remove.exec();
    for (std::size_t position = 0; position < front.members.size(); ++position) {
      const FrontMember& member = front.members[position];
      COPPICE_CHECK(member.values.size() == front.measures.size());
      nlohmann::ordered_json measures = nlohmann::ordered_json::object();
      for (std::size_t m = 0; m < front.measures.size(); ++m) {
        measures[std::string(name_of(front.measures[m]))] = member.values[m];
      }
      SQLite::Statement insert(state_->database, "INSERT INTO fronts VALUES(?, ?, ?, ?, ?)");
      insert.bind(1, number(run));
      insert.bind(2, static_cast<std::int64_t>(position));
      insert.bind(3, to_text(member.tree, chain().vocabulary()));
      insert.bind(4, member.fitness);
      insert.bind(5, measures.dump());
      insert.exec();
    }
    transaction.commit();
    return state_->check_in_place();
  });
}

Result<Front> Study::front(RunId run) const {
  const Vocabulary& vocabulary = chain().vocabulary();
  return guarded(state_->path, [&]() -> Result<Front> {
    SQLite::Statement select(state_->database,
                             "SELECT position, tree, fitness, measures FROM fronts WHERE run = ? ORDER BY position");
    select.bind(1, number(run));
    Front found;
    while (select.executeStep()) {
      const auto row = [&](const std::string& what) {
        return tl::unexpected(
            damaged(state_->path, fmt::format("{}, front, position {}: {}", label(run), found.members.size(), what)));
      };
      auto tree = parse_tree(select.getColumn(1).getString(), vocabulary);
      if (!tree || select.getColumn(0).getUInt() != found.members.size()) {
        return row(tree ? "missing" : tree.error().message);
      }
      FrontMember member{std::move(*tree), select.getColumn(2).getDouble(), {}};
      std::vector<Measure> measures;
      const auto json = nlohmann::ordered_json::parse(select.getColumn(3).getString(), nullptr, false);
      for (const auto& [name, value] : json.items()) {
        const auto measure = measure_named(name);
        if (!measure || !value.is_number()) {
          return row(measure ? fmt::format("{} is no number", name) : measure.error().message);
        }
        measures.push_back(*measure);
        member.values.push_back(value.get<double>());
      }
      if (!json.is_object() || (!found.members.empty() && measures != found.measures)) {
        return row("its measures are not those of the first");
      }
      found.measures = std::move(measures);
      found.members.push_back(std::move(member));
    }
    return found;
  });
}

}  // namespace coppice
