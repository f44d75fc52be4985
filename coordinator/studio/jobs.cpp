#include "coordinator/studio/jobs.hpp"

#include <algorithm>
#include <exception>
#include <fmt/format.h>
#include <utility>
#include <vector>

#include "common/check.hpp"

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;

}  // namespace

struct Jobs::Job : JobProgress {
  explicit Job(std::mutex& jobs_mutex) : mutex(jobs_mutex) {}

  void show(double done, const std::string& what) override {
    const std::lock_guard lock(mutex);
    share = std::clamp(done, 0.0, 1.0);
    text = what;
  }
  void detail(Json value) override {
    const std::lock_guard lock(mutex);
    details = std::move(value);
  }
  const StopFlag& stop() const override { return stop_flag; }

  std::mutex& mutex;  // of the Jobs: guards what follows
  std::string kind;
  Json about;
  std::string state = "running";
  double share = 0.0;
  std::string text;
  Json details;
  std::string error;
  Json result;
  StopFlag stop_flag;
  std::thread thread;
};

Jobs::~Jobs() {
  std::vector<std::shared_ptr<Job>> all;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [id, job] : jobs_) {
      all.push_back(job);
    }
  }
  for (const auto& job : all) {
    job->stop_flag.raise();
  }
  for (const auto& job : all) {
    if (job->thread.joinable()) {
      job->thread.join();
    }
  }
}

Result<std::int64_t> Jobs::start(const std::string& kind, Json about, JobWork work) {
  const std::lock_guard lock(mutex_);
  const auto running =
      std::count_if(jobs_.begin(), jobs_.end(), [](const auto& entry) { return entry.second->state == "running"; });
  if (static_cast<std::size_t>(running) >= kMostJobs) {
    return failed(fmt::format("{} computations are at work already: wait for one, or stop it", running));
  }
  forget_old();
  const std::int64_t id = next_++;
  const auto job = std::make_shared<Job>(mutex_);
  job->kind = kind;
  job->about = std::move(about);
  jobs_[id] = job;
  job->thread = std::thread([this, job = job.get(), work = std::move(work)] {
    Result<Json> done = tl::unexpected(Error{});
    try {
      done = work(*job);
    } catch (const std::exception& error) {
      done = failed(error.what());
    }
    const std::lock_guard at_end(mutex_);
    if (done) {
      job->state = job->stop_flag.raised() ? "stopped" : "done";
      job->share = 1.0;
      job->result = std::move(*done);
    } else {
      job->state = done.error().kind == ErrorKind::interrupted ? "stopped" : "failed";
      job->error = done.error().message;
    }
    ended_.notify_all();
  });
  return id;
}

// REQUIRES: mutex_ is held.
void Jobs::forget_old() {
  auto ended = static_cast<std::size_t>(
      std::count_if(jobs_.begin(), jobs_.end(), [](const auto& entry) { return entry.second->state != "running"; }));
  for (auto at = jobs_.begin(); at != jobs_.end() && ended >= kMostEndedJobs;) {
    if (at->second->state == "running") {
      ++at;
      continue;
    }
    at->second->thread.join();  // it has set its state, and does nothing behind that but let go of the mutex
    at = jobs_.erase(at);
    --ended;
  }
}

bool Jobs::stop(std::int64_t id) {
  std::shared_ptr<Job> job;
  {
    const std::lock_guard lock(mutex_);
    const auto found = jobs_.find(id);
    if (found == jobs_.end() || found->second->state != "running") {
      return false;
    }
    job = found->second;
  }
  job->stop_flag.raise();
  return true;
}

Json Jobs::json_of(std::int64_t id, const Job& job) {
  return {{"job", id},          {"kind", job.kind}, {"about", job.about},    {"state", job.state},
          {"share", job.share}, {"text", job.text}, {"detail", job.details}, {"error", job.error}};
}

Json Jobs::list() const {
  const std::lock_guard lock(mutex_);
  Json all = Json::array();
  for (const auto& [id, job] : jobs_) {
    all.push_back(json_of(id, *job));
  }
  return all;
}

std::optional<Json> Jobs::find(std::int64_t id) const {
  const std::lock_guard lock(mutex_);
  const auto found = jobs_.find(id);
  if (found == jobs_.end()) {
    return std::nullopt;
  }
  Json json = json_of(id, *found->second);
  json["result"] = found->second->result;
  return json;
}

void Jobs::wait(std::int64_t id) {
  std::unique_lock lock(mutex_);
  const auto found = jobs_.find(id);
  COPPICE_CHECK(found != jobs_.end());
  const std::shared_ptr<Job> job = found->second;
  ended_.wait(lock, [&] { return job->state != "running"; });
}

}  // namespace coppice
