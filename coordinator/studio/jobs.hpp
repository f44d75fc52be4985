// Long computations of the studio: each on a thread of its own, with progress, an end, and a way to stop it. Owns the
// threads; its destructor stops and joins them all. Safe to use from any thread.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>

#include "common/error.hpp"
#include "common/stop.hpp"

namespace coppice {

inline constexpr std::size_t kMostJobs = 4;        // at a time; beyond, a new one is refused
inline constexpr std::size_t kMostEndedJobs = 32;  // whose results are kept; the oldest go first

// What a job says while it works.
class JobProgress {
 public:
  virtual ~JobProgress() = default;
  // share in [0, 1]; text: what there is to say beside, may be empty.
  virtual void show(double share, const std::string& text) = 0;
  // More than a line, as a JSON value: what a page draws while the job works.
  virtual void detail(nlohmann::ordered_json detail) = 0;
  virtual const StopFlag& stop() const = 0;
};

using JobWork = std::function<Result<nlohmann::ordered_json>(JobProgress&)>;

class Jobs {
 public:
  Jobs() = default;
  Jobs(const Jobs&) = delete;
  Jobs& operator=(const Jobs&) = delete;
  ~Jobs();

  // `about`: what the page remembers it by, such as the tree. Errors: kMostJobs are at work.
  Result<std::int64_t> start(const std::string& kind, nlohmann::ordered_json about, JobWork work);
  // Asks it to stop; false: there is no such job, or it has ended.
  bool stop(std::int64_t id);

  // All jobs, the newest last, without results: {"job", "kind", "about", "state": "running" | "done" | "stopped" |
  // "failed", "share", "text", "detail", "error"}.
  nlohmann::ordered_json list() const;
  // One with its result; nothing: there is none of this number (any more).
  std::optional<nlohmann::ordered_json> find(std::int64_t id) const;
  // Returns when the job has ended. REQUIRES: it exists.
  void wait(std::int64_t id);

 private:
  struct Job;
  static nlohmann::ordered_json json_of(std::int64_t id, const Job& job);
  void forget_old();

  mutable std::mutex mutex_;
  mutable std::condition_variable ended_;
  std::map<std::int64_t, std::shared_ptr<Job>> jobs_;
  std::int64_t next_ = 1;
};

}  // namespace coppice
