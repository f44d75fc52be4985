// One study that is open in the studio: what its page may ask, as functions from JSON to JSON. Owns the open study and
// the jobs that work on it. Nothing is ever lost: what is kept is one transaction in the study's file, other processes
// may write it at the same time, and trees that are not kept live in the browser.
//
// Thread rule: every member may be called from any thread, several at once. The chain is immutable; the file is used by
// one thread at a time.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/error.hpp"
#include "coordinator/learning/world.hpp"
#include "coordinator/studio/jobs.hpp"
#include "coordinator/studio/page_data.hpp"
#include "coordinator/study/study.hpp"

namespace coppice {

// An evolution that begins with a tree, for those who can run one (coordinator/commands): reports through the job.
using Breed = std::function<Result<nlohmann::ordered_json>(const Tree& founder, const nlohmann::ordered_json& settings,
                                                           JobProgress& progress)>;

class StudioSession {
 public:
  using Json = nlohmann::ordered_json;

  // breed may be empty: then there is no "breed from here". Errors: the study's world cannot be made.
  static Result<std::unique_ptr<StudioSession>> open(Study study, PageRequest request, Breed breed);
  ~StudioSession();

  // What README.md lists under "what the studio answers", by name; `asked` is the body. Errors: bad_input (400), failed
  // (500); nothing: there is no such name.
  std::optional<Result<Json>> answer(const std::string& name, const Json& asked);

 private:
  StudioSession(Study study, PageRequest request, std::optional<World> world, Breed breed);

  Result<Tree> tree_in(const Json& asked, const char* field = "tree") const;
  Result<Json> page();
  Result<Json> status();
  Result<Json> score(const Json& asked) const;
  Result<Json> rules(const Json& asked) const;
  Result<Json> explain(const Json& asked) const;
  Result<Json> prune(const Json& asked) const;
  Result<Json> guard(const Json& asked) const;
  Result<Json> walk(const Json& asked) const;
  Result<Json> keep(const Json& asked);
  Result<Json> forget(const Json& asked);
  Result<Json> keep_rule(const Json& asked);
  Result<Json> forget_rule(const Json& asked);
  Result<Json> simulate(const Json& asked);
  Result<Json> breed(const Json& asked);
  Result<Json> job(const Json& asked) const;
  Result<Json> stop(const Json& asked);
  Result<Json> write(const Json& asked) const;

  mutable std::mutex study_mutex_;
  Study study_;
  const PageRequest request_;
  const std::optional<World> world_;
  const Breed breed_;
  std::atomic<std::uint64_t> own_changes_{0};
  std::int64_t others_changes_ = 0;  // when the problem was read last
  std::int64_t page_job_ = 0;
  Jobs jobs_;  // the last: its threads use the others
};

}  // namespace coppice
