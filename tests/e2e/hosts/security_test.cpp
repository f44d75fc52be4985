// DDS Security: those whose identity was made for the part they play evolve the serial result; whoever else comes gets
// nothing, changes nothing, and does not disturb.
#include "tests/e2e/hosts/remote_study.hpp"

namespace coppice::e2e {
namespace {

const std::vector<std::string> kSettings = {"--seed", "4", "--set", "ga.generations=120"};
constexpr const char* kDomain = "201";  // above those that runs with workers of their own choose from

class Security : public RemoteStudy {
 protected:
  void SetUp() override {
    RemoteStudy::SetUp();
    domain_ = kDomain;
    make_certificates("ours");
  }

  void make_certificates(const std::string& name) const {
    const Completed made =
        run_to_end({.program = COPPICE_SOURCE_DIR "/deploy/security/make-certificates.sh", .arguments = {path(name)}});
    ASSERT_EQ(made.ending, kDone) << made.error;
  }

  std::vector<std::string> secured(std::vector<std::string> arguments, const std::string& identity) const {
    arguments.insert(arguments.end(), {"--security", path(identity)});
    return arguments;
  }

  Command stranger(const std::string& mode, const std::string& identity = {}) const {
    Command result{.program = COPPICE_STRANGER, .arguments = {domain_, mode}};
    if (!identity.empty()) {
      result.arguments.push_back(path(identity));
    }
    return result;
  }
};

TEST_F(Security, LetsThoseWhoBelongEvolveTheSerialResultAndNobodyElseIn) {
  make_certificates("theirs");
  const auto expected = serial_runs(kSettings);
  Process& worker = start_worker(0, secured({"--pace", "2ms"}, "ours/worker"));
  start_worker(0, secured({"--pace", "2ms"}, "ours/worker"));
  const auto coordinator = start_coordinator(secured(kSettings, "ours/coordinator"));
  coordinator->await_error("2 workers");
  start_worker(0);
  start_worker(0, secured({}, "theirs/worker"));
  Process plain(stranger("knock"));
  Process foreign(stranger("knock", "theirs/worker"));
  Process ruler(stranger("rule", "ours/worker"));
  for (Process* knocking : {&plain, &foreign}) {
    EXPECT_EQ(knocking->wait(), kDone) << knocking->rest_of_error();
    EXPECT_EQ(knocking->rest_of_output(), "heard 0 samples\n");
  }
  EXPECT_EQ(ruler.wait(), kDone);
  const auto allowed = lines_of(ruler.rest_of_output());
  ASSERT_EQ(allowed.size(), 4U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NE(allowed[i].find("Not Allowed By Security"), std::string::npos) << allowed[i];
  }
  EXPECT_EQ(allowed[3], "Hello: allowed");

  const auto report = report_of(*coordinator);
  EXPECT_EQ(report["dispatch"]["rejected"], 0);
  EXPECT_EQ(report["dispatch"]["workers_lost"], 0);
  expect_same_runs("study.coppice", expected);
  worker.await_error("the coordinator is gone");
  for (std::size_t i = 2; i < 4; ++i) {  // those who do not belong never met it
    workers_[i]->signal(SIGTERM);
    EXPECT_EQ(workers_[i]->wait(), kDone);
    EXPECT_EQ(workers_[i]->rest_of_error().find("serving"), std::string::npos);
  }
}

TEST_F(Security, KeepsWorkersFromACoordinatorWhoDoesNotBelong) {
  make_certificates("theirs");
  wait_ = "3";
  start_worker(0, secured({}, "ours/worker"));
  for (const auto& arguments : {kSettings, secured(kSettings, "theirs/coordinator")}) {
    const auto coordinator = start_coordinator(arguments);
    EXPECT_EQ(coordinator->wait(), kFailed);
    const std::string said = coordinator->rest_of_error();
    EXPECT_NE(said.find("no worker within 3 s"), std::string::npos) << said;
  }
}

TEST_F(Security, KeepsAWorkersIdentityFromCoordinating) {
  const auto coordinator = start_coordinator(secured(kSettings, "ours/worker"));
  EXPECT_EQ(coordinator->wait(), kFailed);
  const std::string said = coordinator->rest_of_error();
  EXPECT_NE(said.find("Not Allowed By Security"), std::string::npos) << said;
}

TEST_F(Security, NamesWhatIsWrongWithAnIdentity) {
  make_certificates("theirs");
  const auto expect_refusal = [&](const std::string& part) {
    const auto coordinator = start_coordinator(secured({}, "ours/coordinator"));
    EXPECT_EQ(coordinator->wait(), kWrongUse);
    const std::string said = coordinator->rest_of_error();
    EXPECT_NE(said.find(part), std::string::npos) << said;
  };
  const std::string key = read("ours/coordinator/key.pem");
  write("ours/coordinator/key.pem", read("theirs/coordinator/key.pem"));
  expect_refusal("key.pem is not the key of certificate.pem");
  write("ours/coordinator/key.pem", "no key");
  expect_refusal("key.pem holds no private key");
  write("ours/coordinator/key.pem", key);
  write("ours/coordinator/identity_ca.pem", read("theirs/coordinator/identity_ca.pem"));
  expect_refusal("certificate.pem was not signed by identity_ca.pem");
  std::filesystem::remove(path("ours/coordinator/governance.smime"));
  expect_refusal("governance.smime: No such file");
}

}  // namespace
}  // namespace coppice::e2e
