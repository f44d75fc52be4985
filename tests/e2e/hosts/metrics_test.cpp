// Metrics as Prometheus reads them, of real coordinators and workers.
#include <climits>
#include <ctime>
#include <fstream>
#include <iterator>
#include <regex>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/e2e/hosts/watching.hpp"

namespace coppice::e2e {
namespace {

const std::vector<std::string> kEndless = {"--seed", "4", "--set", "ga.generations=100000"};

class Metrics : public Watching {
 protected:
  Metrics() { domain_ = "208"; }

  // With its metrics on a free port.
  std::unique_ptr<Process> start_watched(std::vector<std::string> more) const {
    Command watched = coordinator(std::move(more));
    watched.arguments.insert(watched.arguments.begin(), {"--log-level", "info"});
    watched.arguments.insert(watched.arguments.end(), {"--metrics", "0"});
    return std::make_unique<Process>(watched);
  }
};

TEST_F(Metrics, TellWhatACoordinatorAndItsWorkerDo) {
  Process& worker = start_worker(0, {"--pace", "1ms", "--threads", "2", "--metrics", "127.0.0.1:0"});
  const std::string workers_port = port_of(worker);
  const auto coordinator = start_watched(kEndless);
  const std::string port = port_of(*coordinator);

  const std::map<std::string, std::string> run = {{"run", "study.coppice#1"}};
  const auto metrics = scrape_until(url(port), [&](const nlohmann::json& seen) {
    return value(seen, "coppice_run_generation", run).value_or(0) > 1 &&
           value(seen, "coppice_worker_lanes_ready") == 2 && value(seen, "coppice_sent_bytes_total") > 0 &&
           value(seen, "coppice_received_bytes_total") > 0;
  });
  EXPECT_EQ(value(metrics, "coppice_run_generations", run), 100000);
  EXPECT_GT(value(metrics, "coppice_individuals_total"), 0);
  EXPECT_GT(value(metrics, "coppice_batches_total"), 0);
  EXPECT_GT(value(metrics, "coppice_workers_busy_seconds_total"), 0);
  EXPECT_GT(value(metrics, "coppice_run_best_fitness", run), 0);
  EXPECT_LE(value(metrics, "coppice_run_generation_mean_fitness", run),
            value(metrics, "coppice_run_generation_best_fitness", run));
  EXPECT_EQ(value(metrics, "coppice_worker_lanes_ready"), 2);
  EXPECT_EQ(*value(metrics, "coppice_workers", {{"state", "idle"}}) +
                *value(metrics, "coppice_workers", {{"state", "evaluating"}}),
            1);
  for (const char* name :
       {"coppice_epochs_total", "coppice_units_waiting", "coppice_units_in_flight", "coppice_batches_requeued_total",
        "coppice_answers_duplicate_total", "coppice_samples_rejected_total", "coppice_workers_lost_total",
        "process_cpu_seconds_total"}) {
    EXPECT_TRUE(value(metrics, name).has_value()) << name;
  }

  const auto of_worker = scrape(url(workers_port));
  EXPECT_EQ(value(of_worker, "coppice_worker_serving"), 1);
  EXPECT_EQ(value(of_worker, "coppice_worker_lanes"), 2);
  EXPECT_EQ(value(of_worker, "coppice_worker_chains"), 1);
  EXPECT_GT(value(of_worker, "coppice_worker_individuals_total"), 0);
  EXPECT_GT(value(of_worker, "coppice_worker_busy_seconds_total"), 0);
  EXPECT_GT(value(of_worker, "coppice_worker_tasks_total", {{"outcome", "evaluated"}}), 0);
  EXPECT_GT(value(of_worker, "coppice_worker_received_bytes_total", {{"kind", "chain"}}), 0);

  coordinator->signal(SIGINT);
  coordinator->wait();
  scrape_until(url(workers_port),
               [](const nlohmann::json& seen) { return value(seen, "coppice_worker_serving") == 0; });
}

TEST_F(Metrics, CountLossesAndLiesBySource) {
  Process& lost = start_worker(0, {"--pace", "1ms"});
  std::vector<std::string> settings = kEndless;
  settings.insert(settings.end(), {"--cross-check", "1"});
  const auto coordinator = start_watched(settings);
  const std::string port = port_of(*coordinator);
  coordinator->await_error("1 worker");
  Process liar({.program = COPPICE_LIAR, .arguments = {domain_, "0"}});
  std::string name(HOST_NAME_MAX, '\0');
  gethostname(name.data(), name.size());
  const std::string source = std::string(name.c_str()) + ", pid " + std::to_string(liar.pid());
  scrape_until(url(port), [&](const nlohmann::json& seen) {
    return value(seen, "coppice_workers_quarantined_total") == 1 &&
           value(seen, "coppice_source_disagreeing_total", {{"source", source}}).value_or(0) >= 1;
  });
  lost.signal(SIGKILL);
  lost.wait();
  scrape_until(url(port), [](const nlohmann::json& seen) { return value(seen, "coppice_workers_lost_total") >= 2; });
  coordinator->signal(SIGINT);
  coordinator->wait();
}

TEST_F(Metrics, AreInAFileThatEverybodyMayRead) {
  const Completed evolved = shell(
      "umask 077; exec \"$0\" evolve study.coppice --config thesis --serial --set ga.generations=12"
      " --metrics-file run.prom > report");
  ASSERT_EQ(evolved.ending, kDone) << evolved.error;
  const auto metrics = scrape(path("run.prom"));
  EXPECT_EQ(value(metrics, "coppice_run_generation", {{"run", "study.coppice#1"}}), 12);
  EXPECT_GE(*value(metrics, "coppice_individuals_total"), 12 * 50);
  struct stat status {};
  ASSERT_EQ(stat(path("run.prom").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0644U);
  EXPECT_EQ(files(), (std::vector<std::string>{"report", "run.prom", "study.coppice"}));  // nothing half written
}

TEST_F(Metrics, AreKeptBySweepAndEvaluateToo) {
  write("sweep.toml", "seeds = 2\nepisodes = 0\n[set]\nga.generations = 10\n");
  ASSERT_EQ(coppice({"sweep", "study.coppice", "--config", "sweep.toml", "-o", "swept", "--workers", "1",
                     "--metrics-file", "sweep.prom"})
                .ending,
            kDone);
  const auto swept = scrape(path("sweep.prom"));
  EXPECT_EQ(value(swept, "coppice_sweep_runs"), 2);
  EXPECT_EQ(value(swept, "coppice_sweep_runs_ended"), 2);
  EXPECT_GE(value(swept, "coppice_epochs_total"), 2);
  EXPECT_FALSE(value(swept, "coppice_run_generation").has_value()) << "runs that ended are forgotten";

  const Completed evaluated =
      coppice({"evaluate", "study.coppice", "--workers", "1", "--metrics-file", "evaluate.prom"}, kWallTree + "\n");
  ASSERT_EQ(evaluated.ending, kDone) << evaluated.error;
  EXPECT_EQ(value(scrape(path("evaluate.prom")), "coppice_individuals_total"), 1);
}

TEST_F(Metrics, TellWhenCertificatesEnd) {
  ASSERT_EQ(run_to_end({.program = COPPICE_SOURCE_DIR "/deploy/security/make-certificates.sh",
                        .arguments = {path("ours"), "--days", "20"}})
                .ending,
            kDone);
  Process& worker = start_worker(0, {"--security", path("ours/worker"), "--metrics", "0"});
  const auto metrics = scrape(url(port_of(worker)));
  const double left = *value(metrics, "coppice_certificate_end_seconds", {{"file", "certificate.pem"}}) -
                      static_cast<double>(time(nullptr));
  EXPECT_GT(left, 19.0 * 86400);
  EXPECT_LT(left, 20.1 * 86400);
}

// The dashboard and the alerts ask for nothing that nobody tells.
TEST_F(Metrics, OfTheDashboardAndTheAlertsAreTold) {
  const auto file = [](const std::string& name) {
    std::ifstream in(COPPICE_SOURCE_DIR + ("/" + name));
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  const std::string told = file("coordinator/metrics/run_metrics.cpp") + file("worker/figures.cpp");
  const auto dashboard = nlohmann::json::parse(file("deploy/grafana/coppice.json"));
  std::string asked = file("deploy/grafana/alerts.yaml");
  for (const auto& panel : dashboard["panels"]) {
    for (const auto& target : panel["targets"]) {
      asked += target["expr"].get<std::string>() + "\n";
    }
  }
  const std::regex name("coppice_[a-z_]+");
  std::size_t names = 0;
  for (std::sregex_iterator found(asked.begin(), asked.end(), name), end; found != end; ++found, ++names) {
    EXPECT_NE(told.find('"' + found->str() + '"'), std::string::npos) << found->str();
  }
  EXPECT_GT(names, 25U);
  if (std::filesystem::exists("/usr/bin/promtool")) {
    const Completed checked =
        run_to_end({.program = "/usr/bin/promtool",
                    .arguments = {"check", "rules", COPPICE_SOURCE_DIR "/deploy/grafana/alerts.yaml"}});
    EXPECT_EQ(checked.ending, kDone) << checked.output << checked.error;
  }
}

TEST_F(Metrics, RefuseAPlaceThatCannotBe) {
  const std::vector<std::string> evaluate = {"evaluate", "study.coppice", "--serial"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), evaluate.begin(), evaluate.end());
    return more;
  };
  expect_wrong_use(with({"--metrics", "somewhere:9470"}), {"--metrics somewhere:9470", "[::1]:9470"});
  expect_wrong_use(with({"--metrics", "70000"}), {"--metrics 70000"});
  expect_wrong_use(with({"--metrics-file", "no/such/folder.prom"}), {"--metrics-file", "No such file"});
  Process& holder = start_worker(0, {"--metrics", "0"});
  expect_wrong_use(with({"--metrics", port_of(holder)}), {"cannot listen there", "in use"});
}

}  // namespace
}  // namespace coppice::e2e
