#include "coordinator/study/study.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <span>
#include <sys/stat.h>
#include <unistd.h>

#include "coordinator/problem/world_problem.hpp"
#include "coordinator/study/database.hpp"
#include "coordinator/study/study_state.hpp"

namespace coppice {
namespace {

constexpr std::size_t kMaxChainBytes = 1'000'000'000;  // SQLite's default limit for one value

// Zeros: there is none.
FileId file_id(const std::string& path) {
  struct stat status {};
  return ::stat(path.c_str(), &status) == 0 ? FileId{status.st_dev, status.st_ino} : FileId{};
}

// A file under its temporary name; gone with this object unless it was published.
class Draft {
 public:
  explicit Draft(const std::string& target) : target_(target), path_(fmt::format("{}.new-{}", target, ::getpid())) {
    remove();
  }
  Draft(const Draft&) = delete;
  Draft& operator=(const Draft&) = delete;
  ~Draft() { remove(); }

  const std::string& path() const { return path_; }

  // Gives the file its name once it is on the disk, in one step and only if the name is free.
  Result<void> publish() {
    if (const int error = sync(path_, O_RDONLY); error != 0) {
      return not_written(error);
    }
    int error = ::renameat2(AT_FDCWD, path_.c_str(), AT_FDCWD, target_.c_str(), RENAME_NOREPLACE) == 0 ? 0 : errno;
    if (error == EINVAL || error == ENOSYS) {  // a file system without this flag: a hard link does not replace either
      error = ::link(path_.c_str(), target_.c_str()) == 0 ? 0 : errno;
    }
    if (error == EEXIST) {
      return exists(target_);
    }
    if (error != 0) {
      return not_written(error);
    }
    // So that the new name survives a power cut, too; where a folder cannot be synced, the file is whole all the same.
    const std::string folder = std::filesystem::path(target_).parent_path().string();
    sync(folder.empty() ? "." : folder, O_RDONLY | O_DIRECTORY);
    return {};
  }

  // Makes the file, empty.
  Result<void> try_out() const {
    const int fd = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (fd < 0) {
      return not_written(errno);
    }
    ::close(fd);
    return {};
  }

  static tl::unexpected<Error> exists(const std::string& target) {
    return bad_input(fmt::format("{}: exists already: expected a new file, a study is never overwritten", target));
  }

 private:
  void remove() const { static_cast<void>(std::remove(path_.c_str())); }

  // errno, or 0.
  static int sync(const std::string& path, int flags) {
    const int fd = ::open(path.c_str(), flags | O_CLOEXEC);
    if (fd < 0) {
      return errno;
    }
    const int error = ::fsync(fd) == 0 ? 0 : errno;
    ::close(fd);
    return error;
  }

  tl::unexpected<Error> not_written(int error) const {
    return failed(fmt::format("{}: cannot be written: {}", target_, std::strerror(error)));
  }

  std::string target_;
  std::string path_;
};

Result<void> check_json_object(const char* what, const std::string& text) {
  if (!nlohmann::json::parse(text, nullptr, false).is_object()) {
    return bad_input(fmt::format("{} is not a JSON object", what));
  }
  return {};
}

Result<void> check_target(const std::string& path) {
  std::error_code error;
  if (std::filesystem::exists(std::filesystem::symlink_status(path, error))) {
    return Draft::exists(path);
  }
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  if (!folder.empty() && !std::filesystem::is_directory(folder, error)) {
    return bad_input(fmt::format("{}: there is no folder {}", path, folder.string()));
  }
  return {};
}

}  // namespace

namespace {

Result<ChainHash> write_study(const std::string& path, const std::vector<std::uint8_t>& bytes, const StudyWorld& world,
                              const StudyLearning& learning, const std::string& problem) {
  for (const auto& ok : {check_target(path), check_json_object("learning.settings", learning.settings),
                         check_json_object("learning.outcome", learning.outcome)}) {
    if (!ok) {
      return tl::unexpected(ok.error());
    }
  }
  if (bytes.size() > kMaxChainBytes) {
    return failed(
        fmt::format("{}: the chain takes {} bytes: a study holds at most {}", path, bytes.size(), kMaxChainBytes));
  }
  const ChainHash hash = hash_of(bytes);
  Draft draft(path);
  auto written = guarded(path, [&]() -> Result<void> {
    SQLite::Database database = create_database(draft.path());
    SQLite::Statement insert(database,
                             "INSERT INTO study VALUES(1, strftime('%Y-%m-%dT%H:%M:%SZ', 'now'), ?, ?, ?, ?, ?, ?, ?)");
    insert.bind(1, hash.hex());
    insert.bindNoCopy(2, bytes.data(), static_cast<int>(bytes.size()));
    insert.bind(3, world.kind);
    insert.bind(4, world.room);
    insert.bind(5, learning.settings);
    insert.bind(6, learning.outcome);
    insert.bind(7, problem);
    insert.exec();
    return {};
  });
  if (!written) {
    return tl::unexpected(written.error());
  }
  if (auto ok = draft.publish(); !ok) {
    return tl::unexpected(ok.error());
  }
  return hash;
}

}  // namespace

Result<Study> Study::create(const std::string& path, const Chain& chain, const StudyWorld& world,
                            const StudyLearning& learning, const std::optional<Problem>& problem) {
  const std::string json = problem ? to_json(*problem, chain.vocabulary()) : "";
  if (auto written = write_study(path, to_bytes(chain), world, learning, json); !written) {
    return tl::unexpected(written.error());
  }
  return open(path, Access::write);
}

Result<ChainHash> Study::write_new(const std::string& path, Chain chain, const StudyWorld& world,
                                   const StudyLearning& learning, const std::optional<Problem>& problem) {
  const std::string json = problem ? to_json(*problem, chain.vocabulary()) : "";
  const std::vector<std::uint8_t> bytes = to_bytes(chain);
  { const Chain gone = std::move(chain); }
  return write_study(path, bytes, world, learning, json);
}

Result<void> Study::check_new(const std::string& path) {
  if (auto ok = check_target(path); !ok) {
    return ok;
  }
  return Draft(path).try_out();
}

Result<Study> Study::open(const std::string& path, Access access) {
  return guarded(path, [&]() -> Result<Study> {
    const FileId file = file_id(path);
    auto database = open_database(path, access == Access::write);
    if (!database) {
      return tl::unexpected(database.error());
    }
    SQLite::Statement select(
        *database, fmt::format("SELECT chain, chain_hash, world_kind, world_room, learn_settings, learn_outcome, {} "
                               "FROM study",
                               has_problem(*database) ? "problem" : "''"));
    if (!select.executeStep()) {
      return tl::unexpected(damaged(path, "it holds no chain"));
    }
    const SQLite::Column blob = select.getColumn(0);
    const std::span<const std::uint8_t> bytes(static_cast<const std::uint8_t*>(blob.getBlob()),
                                              static_cast<std::size_t>(blob.getBytes()));
    const ChainHash hash = hash_of(bytes);
    if (hash.hex() != select.getColumn(1).getString()) {
      return tl::unexpected(damaged(
          path, fmt::format("the chain hashes to {}: expected {}", hash.hex(), select.getColumn(1).getString())));
    }
    auto chain = chain_from_bytes(bytes);
    if (!chain) {
      return tl::unexpected(damaged(path, "chain: " + chain.error().message));
    }
    StudyWorld world{select.getColumn(2).getString(), select.getColumn(3).getString()};
    StudyLearning learning{select.getColumn(4).getString(), select.getColumn(5).getString()};
    const std::string text = select.getColumn(6).getString();
    auto problem = text.empty() ? Result<Problem>(problem_of_world(world.kind, chain->vocabulary()))
                                : problem_from_json(text, chain->vocabulary());
    if (!problem) {
      return tl::unexpected(damaged(path, problem.error().message));
    }
    select.reset();
    return Study(std::unique_ptr<State>(new State{path, access, std::move(*database), std::move(*chain), hash,
                                                  std::move(world), std::move(learning), std::move(*problem), file}));
  });
}

Result<void> Study::State::check_in_place() const {
  if (file_id(path) != file) {
    return failed(fmt::format("{}: the study was removed or replaced while it was in use", path));
  }
  return {};
}

Study::Study(std::unique_ptr<State> state) : state_(std::move(state)) {}
Study::Study(Study&&) noexcept = default;

Study& Study::operator=(Study&& other) noexcept {
  std::swap(state_, other.state_);
  return *this;
}

Study::~Study() {
  if (state_ && state_->access == Access::write) {
    settle(state_->database);
  }
}

const std::string& Study::path() const { return state_->path; }
const Chain& Study::chain() const { return state_->chain; }
const ChainHash& Study::chain_hash() const { return state_->chain_hash; }
const StudyWorld& Study::world() const { return state_->world; }
const StudyLearning& Study::learning() const { return state_->learning; }
const Problem& Study::problem() const { return state_->problem; }

Result<void> Study::save_problem(const Problem& problem) {
  return guarded(state_->path, [&]() -> Result<void> {
    if (auto ok = state_->check_in_place(); !ok) {
      return ok;
    }
    SQLite::Statement update(state_->database, "UPDATE study SET problem = ?");
    update.bind(1, to_json(problem, state_->chain.vocabulary()));
    update.exec();
    state_->problem = problem;
    return {};
  });
}

Result<void> Study::read_problem() {
  return guarded(state_->path, [&]() -> Result<void> {
    if (!has_problem(state_->database)) {
      return {};
    }
    SQLite::Statement select(state_->database, "SELECT problem FROM study");
    const std::string text = select.executeStep() ? select.getColumn(0).getString() : "";
    if (text.empty()) {
      return {};
    }
    auto problem = problem_from_json(text, state_->chain.vocabulary());
    if (!problem) {
      return tl::unexpected(damaged(state_->path, problem.error().message));
    }
    state_->problem = std::move(*problem);
    return {};
  });
}

Result<void> Study::change_problem(const std::function<Result<void>(Problem&)>& change) {
  return guarded(state_->path, [&]() -> Result<void> {
    SQLite::Transaction transaction(state_->database, SQLite::TransactionBehavior::IMMEDIATE);
    if (auto ok = read_problem(); !ok) {
      return ok;
    }
    Problem changed = state_->problem;
    if (auto ok = change(changed); !ok) {
      return ok;
    }
    if (auto ok = save_problem(changed); !ok) {
      return ok;
    }
    transaction.commit();
    return {};
  });
}

}  // namespace coppice
