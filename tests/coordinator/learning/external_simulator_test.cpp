#include "coordinator/learning/external_simulator.hpp"

#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <optional>
#include <signal.h>
#include <thread>
#include <vector>

#include "common/tree/text.hpp"
#include "coordinator/learning/child_process.hpp"
#include "coordinator/learning/simulate.hpp"
#include "tests/temporary_folder.hpp"

namespace coppice {
namespace {

using std::chrono::milliseconds;
constexpr milliseconds kLong{60'000};

const Vocabulary kVocabulary = {{{"x", {0, 1, 2}, true, true}}, {"go", "stay"}};

// A simulator as a shell script: its first line, then `answers` as the arms of a case over the request, which may use
// $n, the request's id.
std::string script(const std::string& hello, const std::string& answers) {
  return fmt::format("echo '{}'; n=0; while read -r line; do n=$((n+1)); case \"$line\" in {} esac; done", hello,
                     answers);
}

const std::string kHello = R"({"coppice_simulator":1,"features":["x"],"actions":["go","stay"],"timeout":60})";

// One episode at once. Going leads from 0 to 1 to 2, where the task ends, with reward 1 each; there is only going.
std::string corridor() {
  return script(kHello,
                "*reset*) x=0; echo \"{\\\"id\\\":$n,\\\"observations\\\":[[0]]}\";;"
                "*) x=$((x+1)); if [ $x -eq 2 ]; then e=true; else e=false; fi;"
                " echo \"{\\\"id\\\":$n,\\\"observations\\\":[[$x]],\\\"rewards\\\":[1],\\\"terminated\\\":[$e],"
                "\\\"truncated\\\":[false]}\";;");
}

Tree tree_of(const char* text) { return *parse_tree(text, kVocabulary); }

// Knows x=0 and x=1; the policy goes in the first and stays in the second.
Chain chain_with(NoAction no_action = {}) {
  ChainParts parts;
  parts.vocabulary = kVocabulary;
  parts.features = {0, 1};
  parts.row_begin = {0, 1, 1, 2, 2};
  parts.successor = {1, 0};
  parts.count = {1, 1};
  parts.reward_sum = {1.0, 0.0, 1.0, 0.0};
  parts.q = {1.0, 0.0, 0.0, 1.0};
  parts.policy = {ActionId{0}, ActionId{1}};
  parts.visits = {1, 1};
  parts.no_action = no_action;
  return *Chain::make(std::move(parts));
}

std::string message_of(const std::string& command, const char* tree = "go") {
  const auto records = simulate_tree(outside_world(command, kVocabulary), chain_with(), tree_of(tree),
                                     {.episodes = 2, .steps = 10, .seed = 1});
  return records ? "no error" : records.error().message;
}

TEST(ChildProcess, answers_lines_and_leaves_when_its_input_ends) {
  Result<ChildProcess> child = ChildProcess::start("cat");
  ASSERT_TRUE(child);
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(child->write_line(fmt::format("line {}", i), kLong));
    const Result<std::string> line = child->read_line(kLong);
    ASSERT_TRUE(line) << line.error().message;
    EXPECT_EQ(*line, fmt::format("line {}", i));
  }
}

TEST(ChildProcess, is_not_blocked_by_a_child_that_fills_its_standard_error) {
  Result<ChildProcess> child =
      ChildProcess::start("head -c 3000000 /dev/zero | tr '\\0' 'e' >&2; echo >&2; echo last >&2; echo done");
  ASSERT_TRUE(child);
  const Result<std::string> line = child->read_line(kLong);
  ASSERT_TRUE(line) << line.error().message;
  EXPECT_EQ(*line, "done");
  EXPECT_FALSE(child->read_line(kLong));
  EXPECT_NE(child->last_words().find("\n  last"), std::string::npos);
}

TEST(ChildProcess, passes_a_line_larger_than_any_buffer_both_ways) {
  Result<ChildProcess> child = ChildProcess::start("cat");
  ASSERT_TRUE(child);
  const std::string large(1 << 16, 'x');  // what fits: cat answers while it reads
  ASSERT_TRUE(child->write_line(large, kLong));
  EXPECT_EQ(*child->read_line(kLong), large);
}

TEST(ChildProcess, says_how_a_child_ended_and_what_it_said_last) {
  Result<ChildProcess> child = ChildProcess::start("echo oh no >&2; exit 3");
  const Result<std::string> line = child->read_line(kLong);
  ASSERT_FALSE(line);
  EXPECT_EQ(line.error().message, "it ended with exit code 3; on standard error it said:\n  oh no");
  Result<ChildProcess> killed = ChildProcess::start("kill -9 $$");
  EXPECT_EQ(killed->read_line(kLong).error().message, "signal 9 ended it");
}

TEST(ChildProcess, ends_whatever_the_child_started) {
  pid_t grandchild = 0;
  {
    Result<ChildProcess> child = ChildProcess::start("sleep 1000 & echo $!; wait");
    const Result<std::string> line = child->read_line(kLong);
    ASSERT_TRUE(line);
    grandchild = std::stoi(*line);
    ASSERT_EQ(kill(grandchild, 0), 0);
  }
  // Gone, or a zombie that its new parent has not seen to yet.
  std::string state;
  if (std::FILE* file = std::fopen(fmt::format("/proc/{}/stat", grandchild).c_str(), "r"); file != nullptr) {
    char name[256];
    char letter = '?';
    if (std::fscanf(file, "%*d %255s %c", name, &letter) == 2) {
      state = letter;
    }
    std::fclose(file);
  }
  EXPECT_TRUE(state.empty() || state == "Z") << state;
}

TEST(ExternalSimulator, walks_a_tree_and_the_policy_with_the_records_of_our_own_worlds) {
  const World world = outside_world(corridor(), kVocabulary);
  std::vector<SimulatedStep> seen;
  std::vector<std::vector<std::uint8_t>> after;
  const auto records = simulate_tree(world, chain_with(), tree_of("go"), {.episodes = 3, .steps = 10, .seed = 1}, {},
                                     [&](const SimulatedStep& step) {
                                       seen.push_back(step);
                                       after.emplace_back(step.after.begin(), step.after.end());
                                     });
  ASSERT_TRUE(records) << records.error().message;
  ASSERT_EQ(records->size(), 3U);
  for (const EpisodeRecord& record : *records) {
    EXPECT_EQ(record.steps, 2U);
    EXPECT_EQ(record.reward, 2.0);
    EXPECT_EQ(record.matches, 1U);  // in x=1 the policy stays
    EXPECT_EQ(record.unknown, 0U);
  }
  ASSERT_EQ(seen.size(), 6U);
  EXPECT_EQ(after[0], std::vector<std::uint8_t>{1});
  EXPECT_EQ(after[1], std::vector<std::uint8_t>{0});  // the chain ends no episode: they begin again
  EXPECT_TRUE(seen[1].ended);
  const auto policy = simulate_policy(world, chain_with(), {.episodes = 1, .steps = 10, .seed = 1});
  ASSERT_TRUE(policy);
  EXPECT_EQ(policy->front().matches, policy->front().steps);
}

TEST(ExternalSimulator, holds_the_state_where_a_tree_does_not_act_or_does_what_the_problem_says) {
  const World world = outside_world(corridor(), kVocabulary);
  const SimulateSettings settings{.episodes = 1, .steps = 7, .seed = 1};
  const auto held = simulate_tree(world, chain_with(), tree_of("(sequence x=0 go)"), settings);
  ASSERT_TRUE(held);
  EXPECT_EQ(held->front().steps, 7U);
  EXPECT_EQ(held->front().reward, 1.0);
  const auto named =
      simulate_tree(world, chain_with({NoAction::Kind::named, ActionId{0}}), tree_of("(sequence x=0 go)"), settings);
  ASSERT_TRUE(named);
  EXPECT_EQ(named->front().steps, 2U);
}

TEST(ExternalSimulator, counts_what_the_chain_does_not_know_and_goes_on) {
  const std::string elsewhere =
      script(kHello,
             "*reset*) echo \"{\\\"id\\\":$n,\\\"observations\\\":[[0.5]]}\";;"
             "*) echo \"{\\\"id\\\":$n,\\\"observations\\\":[[7]],\\\"rewards\\\":[-1.5],\\\"terminated\\\":[false],"
             "\\\"truncated\\\":[true]}\";;");
  const auto records =
      simulate_tree(outside_world(elsewhere, kVocabulary), chain_with(), tree_of("(selector (sequence x<=1 go) stay)"),
                    {.episodes = 2, .steps = 9, .seed = 1}, {},
                    [](const SimulatedStep&) { FAIL() << "a step that no chain can count"; });
  ASSERT_TRUE(records) << records.error().message;
  EXPECT_EQ(records->front().unknown, 1U);
  EXPECT_EQ(records->front().steps, 1U);
  EXPECT_EQ(records->front().reward, -1.5);
}

TEST(ExternalSimulator, refuses_nonsense_with_the_command_the_line_and_its_last_words) {
  const std::string reset = "*reset*) echo \"{\\\"id\\\":$n,\\\"observations\\\":[[0]]}\";;";
  const auto stepping = [&](const std::string& answer) { return script(kHello, reset + "*) " + answer + ";;"); };
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"exit 4", "before its first line: it ended with exit code 4"},
      {"/no/such/program", "exit code 127; on standard error it said:"},
      {"echo hello; cat", "its first line: expected an object with \"coppice_simulator\": 1: found 'hello'"},
      {R"(echo '{"coppice_simulator":2}'; cat)", "expected an object with \"coppice_simulator\": 1"},
      {R"(echo '{"coppice_simulator":1,"features":["y"],"actions":["go","stay"]}'; cat)",
       "its features are y: expected those of the study, in order: x"},
      {R"(echo '{"coppice_simulator":1,"features":["x"],"actions":["stay","go"]}'; cat)",
       "its actions are stay, go: expected those of the study, in order: go, stay"},
      {R"(echo '{"coppice_simulator":1,"features":["x"],"actions":["go","stay"],"episodes":0}'; cat)",
       "\"episodes\": expected a whole number, 1 to 4096"},
      {script(kHello, "*) echo '{\"id\":99}';;"), "expected an answer with \"id\": 1: found '{\"id\":99}'"},
      {script(kHello, "*) echo 'x';;"), "expected an answer with \"id\": 1"},
      {script(kHello, "*) echo \"{\\\"id\\\":$n,\\\"error\\\":\\\"the motor is gone\\\"}\";;"), "the motor is gone"},
      {script(kHello, "*) echo \"{\\\"id\\\":$n,\\\"observations\\\":[[0,1]]}\";;"),
       "\"observations\": expected 1 lists of 1 numbers"},
      {script(kHello, "*) echo \"{\\\"id\\\":$n,\\\"observations\\\":[[1e999]]}\";;"), "expected an answer with"},
      {stepping("echo \"{\\\"id\\\":$n,\\\"observations\\\":[[0]],\\\"rewards\\\":[\\\"1\\\"]}\""),
       "\"rewards\": expected"},
      {stepping("echo \"{\\\"id\\\":$n,\\\"observations\\\":[[0]],\\\"rewards\\\":[1],\\\"terminated\\\":[0]}\""),
       "\"terminated\": expected"},
      {stepping("echo dying >&2; exit 1"), "it ended with exit code 1; on standard error it said:\n  dying"},
      {script(R"({"coppice_simulator":1,"features":["x"],"actions":["go","stay"],"timeout":0.05})", "*) ;;"),
       "it did not answer for 0.05 s"},
  };
  for (const auto& [command, message] : cases) {
    const std::string found = message_of(command);
    EXPECT_NE(found.find(message), std::string::npos) << command << "\n" << found;
    EXPECT_NE(found.find("simulator '"), std::string::npos) << found;
  }
}

TEST(ExternalSimulator, says_which_steps_were_collisions_where_it_knows) {
  const std::string hello = R"({"coppice_simulator":1,"features":["x"],"actions":["go","stay"],"collisions":true})";
  const std::string crashing =
      script(hello,
             "*reset*) echo \"{\\\"id\\\":$n,\\\"observations\\\":[[0]]}\";;"
             "*) echo \"{\\\"id\\\":$n,\\\"observations\\\":[[1]],\\\"rewards\\\":[1],\\\"terminated\\\":[false],"
             "\\\"truncated\\\":[true],\\\"collisions\\\":[true]}\";;");
  std::vector<std::optional<bool>> collided;
  const auto watch = [&](const SimulatedStep& step) { collided.push_back(step.collided); };
  const SimulateSettings settings{.episodes = 2, .steps = 10, .seed = 1};
  ASSERT_TRUE(simulate_tree(outside_world(crashing, kVocabulary), chain_with(), tree_of("go"), settings, {}, watch));
  EXPECT_EQ(collided, (std::vector<std::optional<bool>>{true, true}));
  collided.clear();
  ASSERT_TRUE(simulate_tree(outside_world(corridor(), kVocabulary), chain_with(), tree_of("go"), settings, {}, watch));
  EXPECT_EQ(collided, (std::vector<std::optional<bool>>(4)));
}

// The child takes an hour over its first step and does not read on: only a signal ends it.
TEST(ExternalSimulator, is_ended_in_the_middle_of_an_episode_when_the_flag_is_raised) {
  const std::string alive = ::testing::TempDir() + "coppice_simulator_pid";
  std::remove(alive.c_str());
  const std::string slow = script(
      kHello, fmt::format("*reset*) echo \"{{\\\"id\\\":$n,\\\"observations\\\":[[0]]}}\";; *) echo $$ > '{0}.new'; mv "
                          "'{0}.new' '{0}'; exec tail -f /dev/null;;",
                          alive));
  StopFlag stop;
  std::thread raiser([&] {
    // Ends when the child is at its step, or with the test's own limit.
    while (!std::filesystem::exists(alive)) {
      std::this_thread::yield();
    }
    stop.raise();
  });
  SimulateSettings settings{.episodes = 2, .steps = 10, .seed = 1};
  settings.stop = &stop;
  const auto records = simulate_tree(outside_world(slow, kVocabulary), chain_with(), tree_of("go"), settings);
  raiser.join();
  ASSERT_FALSE(records);
  EXPECT_EQ(records.error().kind, ErrorKind::interrupted);
  pid_t child = 0;
  std::ifstream(alive) >> child;
  ASSERT_GT(child, 0);
  EXPECT_NE(::kill(child, 0), 0) << "it is still there";
  // Raised before it begins: nothing is waited for.
  EXPECT_FALSE(simulate_tree(outside_world(corridor(), kVocabulary), chain_with(), tree_of("go"), settings));
  std::remove(alive.c_str());
}

TEST(ExternalSimulator, stops_between_episodes_when_it_is_told_to) {
  int asked = 0;
  const auto records = simulate_tree(outside_world(corridor(), kVocabulary), chain_with(), tree_of("go"),
                                     {.episodes = 100, .steps = 10, .seed = 1}, [&] { return ++asked < 3; });
  ASSERT_FALSE(records);
  EXPECT_EQ(records.error().kind, ErrorKind::interrupted);
}

TEST(SimulateOutside, trees_of_one_call_share_one_process_and_their_figures_are_those_of_each_alone) {
  const testing::TemporaryFolder folder;
  const std::string started = folder / "started";
  const World world = outside_world(fmt::format("echo once >> '{}'; {}", started, corridor()), kVocabulary);
  const std::vector<Tree> trees = {tree_of("go"), tree_of("(selector (sequence x=0 go) go)"), tree_of("go")};
  std::vector<std::size_t> told;
  const auto all = simulate_trees(world, chain_with(), trees, {.episodes = 3, .steps = 10, .seed = 1}, {},
                                  [&](std::size_t done) { told.push_back(done); });
  ASSERT_TRUE(all) << all.error().message;
  EXPECT_EQ(std::filesystem::file_size(started), 5U) << "one line: it was started once";
  EXPECT_EQ(told, (std::vector<std::size_t>{1, 2, 3}));
  ASSERT_EQ(all->size(), 3U);
  for (std::size_t t = 0; t < trees.size(); ++t) {
    const auto alone = simulate_tree(world, chain_with(), trees[t], {.episodes = 3, .steps = 10, .seed = 1});
    ASSERT_TRUE(alone) << alone.error().message;
    ASSERT_EQ((*all)[t].size(), 3U);
    for (std::size_t episode = 0; episode < 3; ++episode) {
      EXPECT_EQ((*all)[t][episode].reward, 2.0);
      EXPECT_EQ((*all)[t][episode].reward, (*alone)[episode].reward);
      EXPECT_EQ((*all)[t][episode].steps, (*alone)[episode].steps);
    }
  }
}

}  // namespace
}  // namespace coppice
