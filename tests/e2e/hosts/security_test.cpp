// DDS Security: those whose identity was made for the part they play evolve the serial result; whoever else comes gets
// nothing, changes nothing, and does not disturb.
#include <map>

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

  // stranger.cpp; it tries to join at the coordinator, and at the worker that has this port.
  static constexpr const char* kWorkerPort = "17520";
  Command usurper(const std::string& identity, const std::string& rules) const {
    return {.program = COPPICE_STRANGER,
            .arguments = {domain_, "usurp", identity == "-" ? identity : path(identity), rules, kWorkerPort}};
  }

  // A true worker's identity with rights that another authority signed: everything is allowed.
  void make_rights_of_another_authority(const std::string& name) const {
    std::filesystem::create_directory(path(name));
    for (const char* own : {"certificate.pem", "key.pem", "identity_ca.pem"}) {
      write(name + "/" + own, read(std::string("ours/worker/") + own));
    }
    for (const char* other : {"governance.smime", "permissions_ca.pem"}) {
      write(name + "/" + other, read(std::string("theirs/worker/") + other));
    }
    const Completed made = shell(
        "sed -i 's/DENY/ALLOW/' theirs/authority/permissions.xml && openssl smime -sign -text"
        " -in theirs/authority/permissions.xml -out " +
        name +
        "/permissions.smime"
        " -signer theirs/authority/permissions_ca.pem -inkey theirs/authority/permissions_ca.key");
    ASSERT_EQ(made.ending, kDone) << made.error;
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

// What the next test would see if nobody were kept out.
TEST_F(Security, IsWhatKeepsAUsurperFromWorkers) {
  Process& worker = start_worker(0, {"--port", kWorkerPort});
  Process alone(usurper("-", "own"));
  EXPECT_EQ(alone.wait(), kDone) << alone.rest_of_error();
  const auto lines = lines_of(alone.rest_of_output());
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_EQ(lines[1], "reached: control 1, task 1, block 1");
  EXPECT_EQ(lines[2], "heard: control 0, what is meant for the coordinator 1");
  worker.await_error("serving the coordinator usurper");
}

// Their own software allows them everything: it is the others' that does not hear or answer them.
TEST_F(Security, HoldsAgainstThoseWhoDoNotHeedTheirOwnRules) {
  make_certificates("theirs");
  make_rights_of_another_authority("selfmade");
  const std::vector<std::string> settings = {"--seed", "4", "--set", "ga.generations=400"};
  const auto expected = serial_runs(settings);
  Process& worker = start_worker(0, secured({"--pace", "2ms", "--port", kWorkerPort}, "ours/worker"));
  start_worker(0, secured({"--pace", "2ms"}, "ours/worker"));
  const auto coordinator = start_coordinator(secured(settings, "ours/coordinator"));
  coordinator->await_error("2 workers");

  const std::map<std::string, Command> usurpers = {
      {"no identity", usurper("-", "own")},
      {"another authority's coordinator", usurper("theirs/coordinator", "own")},
      {"rights signed by another authority", usurper("selfmade", "own")},
      {"rights edited under the signature", usurper("ours/worker", "init_forger")},
      {"a true worker that ignores its rights", usurper("ours/worker", "init_lawless")},
  };
  std::map<std::string, std::unique_ptr<Process>> running;
  for (const auto& [name, command] : usurpers) {
    running.emplace(name, std::make_unique<Process>(command));
  }
  for (const auto& [name, process] : running) {
    EXPECT_EQ(process->wait(), kDone) << name << ": " << process->rest_of_error();
    const bool belongs = name.starts_with("a true worker");
    std::string heard =
        "matched by own rules: 0\nreached: control 0, task 0, block 0\nheard: control 0, what is meant for the "
        "coordinator 0\n";
    if (belongs) {  // a worker may hear who coordinates
      heard =
          "matched by own rules: 1\nreached: control 0, task 0, block 0\nheard: control 1, what is meant for the "
          "coordinator 0\n";
    }
    EXPECT_EQ(process->rest_of_output(), heard) << name;
  }

  const auto report = report_of(*coordinator);
  for (const char* harm : {"rejected", "workers_lost", "requeued", "quarantined"}) {
    EXPECT_EQ(report["dispatch"][harm], 0) << harm;
  }
  expect_same_runs("study.coppice", expected);
  worker.signal(SIGTERM);
  EXPECT_EQ(worker.wait(), kDone);
  const std::string said = worker.rest_of_error();
  EXPECT_EQ(said.find("usurper"), std::string::npos) << said;
}

// Its own software refuses before anything is sent.
TEST_F(Security, RefusesRightsThatWereEdited) {
  std::string rights = read("ours/worker/permissions.smime");
  rights.replace(rights.find("<default>DENY</default>"), 23, "<default>ALLOW</default>");
  write("ours/worker/permissions.smime", rights);
  Process edited(usurper("ours/worker", "own"));
  EXPECT_EQ(edited.wait(), kFailed);
  EXPECT_EQ(edited.rest_of_output(), "");
}

TEST_F(Security, KeepsWorkersFromACoordinatorWhoDoesNotBelong) {
  make_certificates("theirs");
  wait_ = "3";
  start_worker(0, secured({}, "ours/worker"));
  for (const auto& arguments : {kSettings, secured(kSettings, "theirs/coordinator")}) {
    const auto coordinator = start_coordinator(arguments);
    EXPECT_EQ(coordinator->wait(), kNoWorker);
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

// Keys stay where they were made; a host that was revoked is met by nobody who knows it, the others go on.
TEST_F(Security, GivesEveryHostAnIdentityOfItsOwnThatCanBeRevoked) {
  const auto certificates = [&](std::vector<std::string> arguments) {
    const Completed made = run_to_end({.program = COPPICE_SOURCE_DIR "/deploy/security/make-certificates.sh",
                                       .arguments = std::move(arguments),
                                       .folder = path("."),
                                       .environment = {}});
    ASSERT_EQ(made.ending, kDone) << made.error;
  };
  certificates({"authority", "site"});
  for (const auto& [role, name] :
       {std::pair{"coordinator", "c1"}, std::pair{"worker", "w1"}, std::pair{"worker", "w2"}}) {
    certificates({"request", name});
    certificates({"sign", "site", name + std::string("/request.pem"), role, name, "signed"});
    EXPECT_FALSE(exists("signed/key.pem"));
    ASSERT_EQ(shell(std::string("cp signed/* ") + name).ending, kDone);
  }
  const auto expected = serial_runs(kSettings);
  start_worker(0, secured({"--pace", "2ms"}, "w1"));
  start_worker(0, secured({"--pace", "2ms"}, "w2"));
  const auto both = start_coordinator(secured(kSettings, "c1"));
  both->await_error("2 workers");
  report_of(*both);
  expect_same_runs("study.coppice", expected);

  certificates({"revoke", "site", "w1/certificate.pem"});
  std::filesystem::copy_file(path("site/authority/crl.pem"), path("c1/crl.pem"));
  workers_[1]->signal(SIGTERM);
  EXPECT_EQ(workers_[1]->wait(), kDone);
  wait_ = "3";
  const auto without = start_coordinator(secured(kSettings, "c1"));
  EXPECT_NE(without->wait(), kDone) << "w1 is there, and revoked";
  const std::string said = without->rest_of_error();
  EXPECT_NE(said.find("no worker within 3 s"), std::string::npos) << said;
  wait_ = "60";
  start_worker(0, secured({"--pace", "2ms"}, "w2"));
  const auto again = start_coordinator(secured(kSettings, "c1"));
  EXPECT_EQ(report_of(*again)["dispatch"]["workers_lost"], 0);

  // Once it is told, it says so itself.
  std::filesystem::copy_file(path("site/authority/crl.pem"), path("w1/crl.pem"));
  Process& revoked = start_worker(0, secured({}, "w1"));
  EXPECT_EQ(revoked.wait(), kWrongUse);
  const std::string why = revoked.rest_of_error();
  EXPECT_NE(why.find("w1/certificate.pem was revoked"), std::string::npos) << why;
}

// Every certificate is another at the end: workers in turn, then the coordinator; then the list of the revoked names
// one of the old ones.
TEST_F(Security, SurvivesTheRotationOfEveryCertificateWhileARunGoesOn) {
  const auto certificates = [&](std::vector<std::string> arguments) {
    const Completed made = run_to_end({.program = COPPICE_SOURCE_DIR "/deploy/security/make-certificates.sh",
                                       .arguments = std::move(arguments),
                                       .folder = path("."),
                                       .environment = {}});
    ASSERT_EQ(made.ending, kDone) << made.error;
  };
  const auto renew = [&](const std::string& role, const std::string& name) {
    certificates({"request", name});  // another key, too
    certificates({"sign", "site", name + "/request.pem", role, name, "signed"});
    ASSERT_EQ(shell("cp signed/* " + name).ending, kDone);
  };
  certificates({"authority", "site"});
  renew("coordinator", "c1");
  renew("worker", "w1");
  renew("worker", "w2");
  const std::vector<std::string> settings = {"--seed", "4", "--set", "ga.generations=1000"};
  const auto expected = serial_runs(settings);
  start_worker(0, secured({"--pace", "1ms"}, "w1"));
  start_worker(0, secured({"--pace", "1ms"}, "w2"));
  auto coordinator = start_coordinator(secured(settings, "c1"));
  coordinator->await_error("2 workers");
  const std::string before = read("w1/certificate.pem");
  for (const std::string name : {"w1", "w2"}) {
    write("old.pem", read(name + "/certificate.pem"));
    ASSERT_EQ(shell("rm " + name + "/key.pem").ending, kDone);
    renew("worker", name);
    Process& worker = *workers_[name == "w1" ? 0 : 1];
    worker.signal(SIGTERM);
    EXPECT_EQ(worker.wait(), kDone);
    coordinator->await_error(" 1 worker");
    start_worker(0, secured({"--pace", "1ms"}, name));
    coordinator->await_error("2 workers");
  }
  EXPECT_NE(read("w1/certificate.pem"), before);
  certificates({"revoke", "site", "old.pem"});  // the last of the old ones
  coordinator->signal(SIGTERM);
  EXPECT_EQ(coordinator->wait(), kInterrupted);
  ASSERT_EQ(shell("rm c1/key.pem && cp site/authority/crl.pem c1/").ending, kDone);
  renew("coordinator", "c1");
  coordinator = start_coordinator(secured({"--resume"}, "c1"));
  coordinator->await_error("2 workers");
  EXPECT_EQ(report_of(*coordinator)["dispatch"]["workers_lost"], 0);
  expect_same_runs("study.coppice", expected);
}

// Both sides are told when a certificate ends while it is in use; the run goes on with the others.
TEST_F(Security, TellsWhoseCertificateEndedInMidRun) {
  if (!std::filesystem::exists(kFakeTime)) {
    GTEST_SKIP() << "no " << kFakeTime << ": deploy/install-packages.sh tests installs it";
  }
  const auto sign = [&](const std::string& name, const std::string& clock) {
    // Of one day, made almost a day ago.
    const Completed made =
        shell("set -e; M=" COPPICE_SOURCE_DIR "/deploy/security/make-certificates.sh; $M authority site; $M request " +
              name + "; LD_PRELOAD=" + kFakeTime + " FAKETIME='" + clock + "' $M sign site " + name +
              "/request.pem worker " + name + " signed --days 1; cp signed/* " + name);
    ASSERT_EQ(made.ending, kDone) << made.error;
  };
  sign("short", "-86370");  // 30 s are left
  ASSERT_EQ(
      shell(
          "M=" COPPICE_SOURCE_DIR
          "/deploy/security/make-certificates.sh; $M request c1 && $M sign site c1/request.pem coordinator c1 "
          "signed && cp signed/* c1 && $M request w2 && $M sign site w2/request.pem worker w2 signed && cp signed/* w2")
          .ending,
      kDone);
  const std::vector<std::string> endless = {"--seed", "4", "--set", "ga.generations=100000"};
  Process& ending = start_worker(0, secured({"--pace", "1ms"}, "short"));
  start_worker(0, secured({"--pace", "1ms"}, "w2"));
  const auto coordinator = start_coordinator(secured(endless, "c1"));
  ending.await_error("short/certificate.pem ends in 0 days");
  coordinator->await_error("2 workers");
  ending.await_error("short/certificate.pem ended at ");
  coordinator->await_error(" 1 worker");
  coordinator->signal(SIGTERM);
  EXPECT_EQ(coordinator->wait(), kInterrupted);
}

TEST_F(Security, WarnsBeforeAnIdentityEnds) {
  const Completed made = run_to_end({.program = COPPICE_SOURCE_DIR "/deploy/security/make-certificates.sh",
                                     .arguments = {path("short"), "--days", "20"}});
  ASSERT_EQ(made.ending, kDone) << made.error;
  Process& worker = start_worker(0, secured({}, "short/worker"));
  worker.await_error("short/worker/certificate.pem ends in");
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
  ASSERT_EQ(shell("chmod 644 ours/coordinator/key.pem").ending, kDone);
  expect_refusal("key.pem can be read by everybody on this machine (mode 644)");
  ASSERT_EQ(shell("chmod 600 ours/coordinator/key.pem").ending, kDone);
  write("ours/coordinator/crl.pem", "no list");
  expect_refusal("crl.pem is no list of revoked certificates");
  std::filesystem::remove(path("ours/coordinator/crl.pem"));
  write("ours/coordinator/identity_ca.pem", read("theirs/coordinator/identity_ca.pem"));
  expect_refusal("certificate.pem was not signed by identity_ca.pem");
  std::filesystem::remove(path("ours/coordinator/governance.smime"));
  expect_refusal("governance.smime: No such file");
}

}  // namespace
}  // namespace coppice::e2e
