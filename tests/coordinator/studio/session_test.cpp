// What the studio answers, without a network: kept trees, scores, rules, and questions that make no sense.
#include <gtest/gtest.h>
#include <thread>

#include "common/tree/text.hpp"
#include "coordinator/studio/studio_server.hpp"
#include "coordinator/studio/studio_session.hpp"
#include "tests/coordinator/studio/studio_study.hpp"

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;
using testing::StudioStudy;
using testing::tree_of;

constexpr const char* kSessionTree = "(selector (sequence a=0 left) move)";

class StudioSessions : public ::testing::Test {
 protected:
  std::unique_ptr<StudioSession> open(Breed breed = {}) {
    auto study = Study::open(files_.path);
    EXPECT_TRUE(study);
    auto session =
        StudioSession::open(std::move(*study), StudioStudy::request(tree_of(kSessionTree)), std::move(breed));
    EXPECT_TRUE(session);
    return std::move(*session);
  }
  static Json ask(StudioSession& session, const std::string& name, const Json& asked = Json::object()) {
    const auto answer = session.answer(name, asked);
    EXPECT_TRUE(answer) << name;
    return *answer ? **answer : Json{{"error", answer->error().message}};
  }

  StudioStudy files_;
};

TEST_F(StudioSessions, ScoreATreeAsTheReportDoes) {
  const auto session = open();
  const Json scored = ask(*session, "score", {{"tree", kSessionTree}});
  EXPECT_EQ(scored["text"], kSessionTree);
  const auto data = page_data(files_.study, StudioStudy::request(tree_of(kSessionTree)), {});
  EXPECT_EQ(scored, (*data)["answer"]["tree"]);
}

TEST_F(StudioSessions, KeepTreesInTheStudyWhereTheNextOneFindsThem) {
  {
    const auto session = open();
    EXPECT_EQ(ask(*session, "keep", {{"tree", kSessionTree}, {"name", "mine"}, {"note", "a 'note'"}})["id"], 1);
    EXPECT_EQ(ask(*session, "keep", {{"tree", "move"}, {"name", "other"}, {"note", ""}})["id"], 2);
    EXPECT_TRUE(ask(*session, "keep", {{"tree", "move"}, {"name", ""}, {"note", ""}}).contains("error"));
  }
  const auto session = open();
  EXPECT_EQ(ask(*session, "forget", {{"id", 2}}), Json::object());
  EXPECT_TRUE(ask(*session, "forget", {{"id", 2}}).contains("error"));
  const Json kept = ask(*session, "status")["kept"];
  ASSERT_EQ(kept.size(), 1U);
  EXPECT_EQ(kept[0]["name"], "mine");
  EXPECT_EQ(kept[0]["note"], "a 'note'");
  EXPECT_EQ(kept[0]["tree"], kSessionTree);
}

TEST_F(StudioSessions, KeepRulesInTheStudyAndLoseNoneOfAnotherSession) {
  {
    const auto one = open();
    const auto other = open();
    EXPECT_EQ(ask(*one, "keep_rule", {{"rule", "never left"}}), Json::object());
    EXPECT_EQ(ask(*other, "keep_rule", {{"rule", "never move when a=0"}}), Json::object());
    EXPECT_EQ(ask(*one, "keep_rule", {{"rule", "never left"}}), Json::object()) << "again: once is enough";
    const Json both = {"never left", "never move when a=0"};
    EXPECT_EQ(ask(*one, "status")["rules"], both);
    EXPECT_EQ(ask(*other, "status")["rules"], both);
    EXPECT_TRUE(ask(*one, "keep_rule", {{"rule", "never fly"}}).contains("error"));
    EXPECT_EQ(ask(*one, "forget_rule", {{"rule", "never left"}}), Json::object());
  }
  const auto again = Study::open(files_.path, Study::Access::read);
  EXPECT_EQ(again->problem().rules, std::vector<std::string>{"never move when a=0"});
}

TEST_F(StudioSessions, NoticeWhatOthersWrite) {
  const auto session = open();
  const Json before = ask(*session, "status")["changes"];
  EXPECT_EQ(ask(*session, "status")["changes"], before);
  ASSERT_TRUE(files_.study.begin_run({EvolveConfig{}, "elsewhere"}));
  EXPECT_NE(ask(*session, "status")["changes"], before);
  EXPECT_EQ(ask(*session, "runs").size(), 1U);
}

TEST_F(StudioSessions, LoseNothingWhenManyAskAtOnce) {
  const auto session = open();
  constexpr int kThreads = 4;
  constexpr int kEach = 10;
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < kEach; ++i) {
        EXPECT_FALSE(ask(*session, "keep", {{"tree", kSessionTree}, {"name", std::to_string(t)}, {"note", ""}})
                         .contains("error"));
        ask(*session, "score", {{"tree", kSessionTree}});
        ask(*session, "status");
      }
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  EXPECT_EQ(ask(*session, "status")["kept"].size(), static_cast<std::size_t>(kThreads * kEach));
}

TEST_F(StudioSessions, PruneAndGuardWithoutChangingWhatTheTreeDoes) {
  const auto session = open();
  const Json pruned = ask(*session, "prune", {{"tree", "(selector (sequence a=0 left) move right)"}});
  EXPECT_EQ(pruned["tree"], kSessionTree);
  EXPECT_EQ(pruned["removals"].size(), 1U);
  const Json guarded = ask(*session, "guard", {{"tree", "(selector (sequence left a=0) move)"}});
  EXPECT_EQ(ask(*session, "score", {{"tree", guarded["tree"]}})["figures"],
            ask(*session, "score", {{"tree", "(selector (sequence left a=0) move)"}})["figures"]);
}

TEST_F(StudioSessions, SimulateInTheBackground) {
  const auto session = open();
  const std::int64_t job = ask(*session, "simulate", {{"tree", kSessionTree}})["job"].get<std::int64_t>();
  Json found;
  do {  // ends with the computation, which has an end
    found = ask(*session, "job", {{"job", job}});
  } while (found["state"] == "running");
  EXPECT_EQ(found["state"], "done") << found.dump();
  EXPECT_TRUE(found["result"]["promise"]["tree"].is_null()) << "this study has no simulator";
  const Json& reward = found["result"]["promise"]["chain"]["reward_per_episode"];
  EXPECT_LT(reward["low"].get<double>(), reward["high"].get<double>());
}

TEST_F(StudioSessions, SayWhatIsWrongWithAQuestion) {
  const auto session = open();
  for (const auto& [name, asked, part] : std::vector<std::tuple<const char*, Json, const char*>>{
           {"score", Json::object(), "\"tree\" is missing"},
           {"score", {{"tree", 5}}, "\"tree\" is missing"},
           {"score", {{"tree", "(selector jump)"}}, "jump"},
           {"rules", {{"tree", "move"}}, "\"rules\" is missing"},
           {"rules", {{"tree", "move"}, {"rules", {5}}}, "no text"},
           {"walk", {{"tree", "move"}, {"features", {1, 2}}}, "\"features\" is missing"},
           {"walk", {{"tree", "move"}, {"features", {-1, 0, 0, 0}}}, "no value"},
           {"job", {{"job", 77}}, "no computation"},
           {"write", {{"tree", "move"}, {"format", "exe"}}, "exe"},
           {"breed", {{"tree", "move"}}, "cannot breed"}}) {
    const Json answer = ask(*session, name, asked);
    ASSERT_TRUE(answer.contains("error")) << name << asked;
    EXPECT_NE(answer["error"].get<std::string>().find(part), std::string::npos) << answer["error"];
  }
  EXPECT_FALSE(session->answer("no_such", Json::object()));
}

TEST_F(StudioSessions, AreBehindTheGate) {
  const auto session = open();
  const StudioGate gate{.token = "secret", .port = 80};
  HttpRequest request{
      .method = "POST",
      .path = "/api/status",
      .headers = {{"host", "127.0.0.1:80"}, {"content-type", "application/json"}, {"x-coppice-token", "secret"}},
      .body = "{}"};
  EXPECT_EQ(answer_of(gate, *session, request).status, 200U);
  request.body = "nonsense";
  EXPECT_EQ(answer_of(gate, *session, request).status, 400U);
  request.body = "{}";
  request.method = "GET";
  EXPECT_EQ(answer_of(gate, *session, request).status, 405U);
  request.method = "POST";
  request.path = "/api/../study";
  EXPECT_EQ(answer_of(gate, *session, request).status, 404U);
  request.headers["x-coppice-token"] = "wrong";
  EXPECT_EQ(answer_of(gate, *session, request).status, 403U);
}

}  // namespace
}  // namespace coppice
