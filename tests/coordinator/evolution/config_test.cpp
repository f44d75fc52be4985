#include <fstream>
#include <gtest/gtest.h>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "common/evolution/config_keys.hpp"
#include "coordinator/evolution/config_text.hpp"
#include "coordinator/evolution/recipe.hpp"
#include "tests/coordinator/evolution/small_world.hpp"
#include "tests/temporary_folder.hpp"

namespace coppice {
namespace {

using testing::small_vocabulary;

const std::string kThesisFile = std::string(COPPICE_SOURCE_DIR) + "/coordinator/evolution/thesis.toml";

EvolveConfig unusual_config() {
  EvolveConfig config;
  config.seed = std::numeric_limits<std::uint64_t>::max();
  config.ga = {7,
               8,
               0.1,
               1.0 / 3.0,
               0.7,
               1e-17,
               9,
               2,
               0,
               99,
               98,
               Form::guarded,
               Search::front,
               Simplification::lossless,
               Seeding::greedy,
               0.3,
               0.4,
               0.45,
               77,
               "(selector (sequence a=0 left) move); left"};
  config.rollout = {11,
                    12,
                    13,
                    Acting::mixed,
                    0.123456789012345678,
                    Schedule::linear,
                    0.25,
                    Start::uniform,
                    Method::discounted,
                    Method::exact,
                    0.987654321};
  config.fitness = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 1.1, 1.2,
                    1.3, 1.4, 5.0, 6.0, 0.7, 8.5, 0.9, {{{"a=0", "d<=2"}, 8, -4}, {{}, 1, 0}}};
  config.front = {
      {kNodesMeasure, measure_of(ObjectiveKind::regret)}, 17, 3, 5, "best regret with nodes<=4", Prefer::coverage};
  return config;
}

// The comments behind the keys of a TOML file, by full name; a comment may go on in lines of its own.
std::map<std::string, std::string> comments_of(const std::string& path) {
  std::map<std::string, std::string> comments;
  std::ifstream file(path);
  std::string section;
  std::string key;
  for (std::string line; std::getline(file, line);) {
    const std::size_t mark = line.find("# ");
    const std::size_t equals = line.find(" = ");
    if (!line.empty() && line.front() == '[') {
      section = line.substr(1, line.find(']') - 1) + ".";
    }
    if (mark == std::string::npos || mark == 0 || line.front() == '[') {
      key.clear();
    } else if (line.front() != ' ') {
      key = section + line.substr(0, equals);
      comments[key] = line.substr(mark + 2);
    } else if (!key.empty()) {
      comments[key] += " " + line.substr(mark + 2);
    }
  }
  return comments;
}

TEST(Config, TheThesisFileSaysOfEachKeyWhatTheTableOfKeysSays) {
  EvolveConfig config;
  const auto comments = comments_of(kThesisFile);
  const std::vector<ConfigKey> keys = keys_of(config);
  EXPECT_EQ(comments.size(), keys.size());
  for (const ConfigKey& key : keys) {
    const auto comment = comments.find(key.full_name());
    ASSERT_NE(comment, comments.end()) << key.full_name();
    EXPECT_EQ(comment->second, key.help) << key.full_name();
    EXPECT_FALSE(key.help.empty()) << key.full_name();
  }
}

TEST(Config, DefaultsAreTableIIIOfTheThesis) {
  const EvolveConfig config;
  EXPECT_EQ(config.ga.generations, 400U);
  EXPECT_EQ(config.ga.population, 100U);
  EXPECT_EQ(config.ga.tournament, 0.08);
  EXPECT_EQ(config.ga.crossover, 0.5);
  EXPECT_EQ(config.ga.mutation, 0.3);
  EXPECT_EQ(config.ga.headless_chicken, 0.1);
  EXPECT_EQ(config.ga.max_depth, 3U);
  EXPECT_EQ(config.ga.max_children, 4U);
  EXPECT_EQ(config.rollout.rollouts, 5U);
  EXPECT_EQ(config.rollout.steps, 100U);
  EXPECT_EQ(config.rollout.acting, Acting::tree);
  EXPECT_EQ(config.rollout.method, Method::rollouts);
}

TEST(Config, TheExampleFileStatesTheDefaults) {
  EvolveConfig config = unusual_config();
  config.fitness.rules.clear();
  const auto ok = load_config(kThesisFile, config);
  ASSERT_TRUE(ok.has_value()) << ok.error().message;
  EXPECT_EQ(config, EvolveConfig{}) << "a key is missing from the file, or is not at its default";
}

TEST(Config, TheRulesInTheExampleFileAreValidOnceUncommented) {
  std::ifstream file(kThesisFile);
  std::string text(std::istreambuf_iterator<char>(file), {});
  text = text.substr(text.find("# [[fitness.rule]]"));
  for (std::size_t at = text.find("# "); at != std::string::npos; at = text.find("\n# ", at)) {
    text.erase(at == 0 ? 0 : at + 1, 2);
  }
  EvolveConfig config;
  const auto ok = read_config(text, "rules", config);
  ASSERT_TRUE(ok.has_value()) << ok.error().message;
  const std::vector<RuleConfig> expected = {{{"s3=3", "s4=3", "s5=3"}, 8, -4}, {{"s3=0"}, 1, -2}, {{}, 1, 0}};
  EXPECT_EQ(config.fitness.rules, expected);
}

TEST(Config, TheRecipesForFrontsAreValid) {
  for (const char* recipe : {"best.toml", "front.toml", "coverage.toml", "return.toml"}) {
    EvolveConfig config;
    const auto ok = load_config(std::string(COPPICE_SOURCE_DIR) + "/coordinator/evolution/" + recipe, config);
    ASSERT_TRUE(ok.has_value()) << ok.error().message;
    EXPECT_EQ(config.ga.search, Search::front);
    const auto checked = check_config(config, small_vocabulary());
    EXPECT_TRUE(checked.has_value()) << recipe << ": " << checked.error().message;
  }
}

TEST(Config, ARecipeIsFoundByItsNameAndAFileByItsPath) {
  for (const Recipe& recipe : recipes()) {
    EvolveConfig by_name;
    EvolveConfig by_path;
    const auto found = load_recipe_or_file(std::string(recipe.name), by_name);
    ASSERT_TRUE(found.has_value()) << found.error().message;
    const auto loaded = load_recipe_or_file(
        std::string(COPPICE_SOURCE_DIR) + "/coordinator/evolution/" + std::string(recipe.name) + ".toml", by_path);
    ASSERT_TRUE(loaded.has_value()) << loaded.error().message;
    EXPECT_EQ(by_name, by_path) << recipe.name;
  }
  EvolveConfig config;
  const auto unknown = load_recipe_or_file("retrun", config);
  ASSERT_FALSE(unknown.has_value());
  EXPECT_NE(unknown.error().message.find("expected a file, or one of " + recipe_names()), std::string::npos);
  EXPECT_EQ(config, EvolveConfig{});
}

TEST(Config, OnlyAFrontClimbs) {
  EvolveConfig config;
  config.ga.guided = 0.5;
  const auto scalar = check_config(config, small_vocabulary());
  ASSERT_FALSE(scalar.has_value());
  EXPECT_EQ(scalar.error().message, "ga.guided is 0.5: expected 0 where ga.search is not \"front\"");
  config.ga.search = Search::front;
  EXPECT_TRUE(check_config(config, small_vocabulary()).has_value());
}

TEST(Config, AFrontRefusesWhatItCannotKeep) {
  const auto message = [](std::initializer_list<const char*> settings) {
    EvolveConfig config;
    for (const char* setting : settings) {
      if (const auto ok = apply_setting(setting, config); !ok) {
        return ok.error().message;
      }
    }
    const auto ok = check_config(config, small_vocabulary());
    return ok ? std::string("accepted") : ok.error().message;
  };
  EXPECT_EQ(message({"ga.search=front"}), "accepted");
  EXPECT_EQ(message({"ga.search=both"}),
            "--set ga.search=both: ga.search is \"both\": expected \"scalar\" or \"front\"");
  EXPECT_EQ(message({"front.pick=best return with size<=3"}).rfind("front.pick: no measure 'size'", 0), 0U);
  EXPECT_NE(message({"front.objectives=agreement, agreement"}).find("named twice"), std::string::npos);
  EXPECT_NE(message({"ga.search=front", "front.restarts=400"}).find("expected fewer than ga.generations"),
            std::string::npos);
  EXPECT_NE(message({"rollout.schedule=linear"}).find("only a mixed acting policy"), std::string::npos);
  EXPECT_NE(message({"rollout.start=visits", "rollout.method=exact"}).find("only roll-outs"), std::string::npos);
  EXPECT_NE(message({"rollout.start=visits", "rollout.final_method=exact"}).find("rollout.final_method"),
            std::string::npos);
  EXPECT_NE(message({"rollout.final_method=long_run"}).find("expected \"rollouts\", or \"exact\""), std::string::npos);
  EXPECT_NE(message({"rollout.method=exact", "rollout.final_method=exact"}).find("after roll-outs"), std::string::npos);
  EXPECT_NE(message({"ga.search=front", "rollout.acting=mixed", "rollout.schedule=step"}).find("rollout.schedule"),
            std::string::npos);
}

TEST(Config, TheLastComparisonMayBeComputed) {
  EvolveConfig config;
  ASSERT_TRUE(apply_setting("rollout.final_method=exact", config));
  EXPECT_EQ(job_of(config, {}, 7).method, Method::rollouts);
  const Job last = job_of(config, {}, kFinalGeneration);
  EXPECT_EQ(last.method, Method::exact);
  EXPECT_EQ(last.rollouts, 1U);
  EXPECT_EQ(last.seed, 0U);
  EXPECT_EQ(last.steps, config.rollout.steps);
}

TEST(Config, FoundersAreTreesWithinTheLimits) {
  const auto message = [](const std::string& founders) {
    EvolveConfig config;
    config.ga.population = 3;
    config.ga.max_nodes = 6;
    config.ga.founders = founders;
    const auto ok = check_config(config, small_vocabulary());
    return ok ? std::string("accepted") : ok.error().message;
  };
  EXPECT_EQ(message("left"), "accepted");
  EXPECT_EQ(message("(selector (sequence a=0 left) move) ;left;(selector b=3 right)"), "accepted");
  EXPECT_EQ(message("left; (selector").rfind("ga.founders: tree 2: ", 0), 0U) << message("left; (selector");
  EXPECT_EQ(message("left;").rfind("ga.founders: tree 2: ", 0), 0U);
  EXPECT_NE(message("(selector left)").find("tree 1, of 2 nodes, is outside the limits"), std::string::npos);
  EXPECT_NE(message("(sequence a=0 b=0 c=0 d=0 (selector a=1 left))").find("ga.max_nodes (6)"), std::string::npos);
  EXPECT_EQ(message("left; left; left; left"),
            "ga.founders: more trees than ga.population, which is 3: expected as many at most");
}

TEST(Config, AScheduleMovesThePolicysShareOverTheGenerations) {
  EvolveConfig config;
  config.ga.generations = 5;
  config.rollout.acting = Acting::mixed;
  config.rollout.policy_share = 1.0;
  config.rollout.policy_share_end = 0.0;
  const auto shares = [&](Schedule schedule) {
    config.rollout.schedule = schedule;
    std::vector<double> result;
    for (const std::uint32_t generation : {0U, 1U, 2U, 4U, kFinalGeneration}) {
      result.push_back(fixed_point_value(job_of(config, {Objective{}}, generation).policy_share));
    }
    return result;
  };
  EXPECT_EQ(shares(Schedule::constant), (std::vector<double>{1.0, 1.0, 1.0, 1.0, 1.0}));
  EXPECT_EQ(shares(Schedule::linear), (std::vector<double>{1.0, 0.75, 0.5, 0.0, 0.0}));
  EXPECT_EQ(shares(Schedule::step), (std::vector<double>{1.0, 1.0, 0.0, 0.0, 0.0}));
}

TEST(Config, JsonRoundTripIsExact) {
  for (const EvolveConfig& config : {EvolveConfig{}, unusual_config()}) {
    const auto read = config_from_json(config_to_json(config));
    ASSERT_TRUE(read.has_value()) << read.error().message;
    EXPECT_EQ(*read, config);
  }
  EXPECT_EQ(config_to_json(unusual_config()).find('\n'), std::string::npos);
}

TEST(Config, JsonErrorsNameTheKey) {
  const auto message = [](std::string_view json) {
    const auto config = config_from_json(json);
    return config ? std::string("accepted") : config.error().message;
  };
  EXPECT_EQ(message("[1"), "configuration: expected a JSON object");
  EXPECT_EQ(message(R"({"ga":3})"), "ga: expected a JSON object");
  EXPECT_EQ(message(R"({"ga":{"population":null}})"),
            "ga.population is a JSON null: expected an integer from 2 to 1000000");
  EXPECT_NE(message(R"({"gal":{}})").find("unknown key 'gal'"), std::string::npos);
  EXPECT_NE(message(R"({"fitness":{"rule":[{"rigth":3}]}})").find("'rigth' in [fitness.rule]"), std::string::npos);
  EXPECT_NE(message(R"({"fitness":{"rule":7}})").find("fitness.rule"), std::string::npos);
  EXPECT_NE(message(R"({"fitness":{"rule":[{"any_of":[1]}]}})").find("any_of"), std::string::npos);
}

struct BadFile {
  std::string text;
  std::vector<std::string> says;
};

TEST(Config, TomlErrorsNameFileLineKeyAndWhatWasExpected) {
  const std::vector<BadFile> files = {
      {"[ga]\n\npopulaton = 3\n", {"run.toml: line 3: ", "'populaton' in [ga]", "generations, population, tournament"}},
      {"[gaa]\npopulation = 3\n", {"run.toml: line 1: ", "'gaa'", "seed, [ga], [rollout], [fitness]"}},
      {"[ga]\npopulation = \"many\"\n",
       {"run.toml: line 2: ga.population is \"many\": expected an integer from 2 to 1000000"}},
      {"[ga]\npopulation = 1\n", {"line 2: ga.population is 1: expected an integer from 2 to 1000000"}},
      {"[ga]\npopulation = 50.5\n", {"line 2: ga.population is 50.5: expected an integer"}},
      {"[ga]\npopulation = true\n", {"line 2: ga.population is true"}},
      {"[ga]\npopulation = [1]\n", {"line 2: ga.population is a list"}},
      {"[ga]\npopulation = 2016-11-09\n", {"line 2: ga.population is a date or time"}},
      {"seed = -1\n", {"line 1: seed is -1: expected an integer from 0 to 18446744073709551615"}},
      {"[ga]\ncrossover = 1.5\n", {"line 2: ga.crossover is 1.5: expected a number from 0 to 1"}},
      {"[ga]\ncrossover = nan\n", {"line 2: ga.crossover is nan: expected a number from 0 to 1"}},
      {"[fitness]\nreturn = inf\n", {"line 2: fitness.return is inf: expected a number from 0 to 1000000"}},
      {"[rollout]\nacting = \"trees\"\n",
       {"line 2: rollout.acting is \"trees\": expected \"tree\", \"policy\" or \"mixed\""}},
      {"[rollout]\nmethod = \"exactly\"\n",
       {"line 2: rollout.method is \"exactly\": expected \"rollouts\", \"exact\", \"discounted\" or \"long_run\""}},
      {"[rollout]\ngamma = 1.0\n", {"line 2: rollout.gamma is 1: expected a number from 0 to 0.999999"}},
      {"ga = 3\n", {"line 1: ga is", "expected a table [ga]"}},
      {"[fitness]\nrule = 3\n", {"line 2: fitness.rule: expected tables [[fitness.rule]]"}},
      {"[[fitness.rule]]\nany_of = \"a=0\"\n", {"line 2: fitness.rule.any_of: expected a list of conditions"}},
      {"[[fitness.rule]]\nany_of = [\n\"a=0\",\n3]\n", {"line 4: fitness.rule.any_of: expected a list of conditions"}},
      {"[[fitness.rule]]\nrigth = 3\n", {"line 2: ", "'rigth' in [fitness.rule]", "right, wrong, any_of"}},
      {"[[fitness.rule]]\nright = 1e9\n", {"line 2: fitness.rule.right is"}},
      {"[ga\npopulation = 3\n", {"run.toml: line 1, column"}},
      {"[ga]\npopulation = 3\npopulation = 4\n", {"run.toml: line 3"}},
      {"\"\" = 3\n", {"line 1: unknown key ''"}},
      {"seed = 1\n\n[,ga]\n", {"run.toml: line 3"}},
  };
  for (const BadFile& file : files) {
    EvolveConfig config = unusual_config();
    const auto ok = read_config("" + file.text, "run.toml", config);
    ASSERT_FALSE(ok.has_value()) << file.text;
    EXPECT_EQ(ok.error().kind, ErrorKind::bad_input);
    for (const std::string& part : file.says) {
      EXPECT_NE(ok.error().message.find(part), std::string::npos)
          << "'" << ok.error().message << "' does not say '" << part << "'";
    }
    EXPECT_EQ(config, unusual_config()) << "a refused file must change nothing: " << file.text;
  }
}

TEST(Config, AFileChangesOnlyWhatItNames) {
  EvolveConfig config = unusual_config();
  ASSERT_TRUE(read_config("[ga]\npopulation = 77\n[fitness]\ncoverage = 2\n", "f", config).has_value());
  EvolveConfig expected = unusual_config();
  expected.ga.population = 77;
  expected.fitness.coverage = 2.0;
  EXPECT_EQ(config, expected);
}

TEST(Config, AFileThatCannotBeReadIsNamed) {
  EvolveConfig config;
  for (const std::string path : {"/nowhere/at/all.toml", "/"}) {
    const auto ok = load_config(path, config);
    ASSERT_FALSE(ok.has_value());
    EXPECT_EQ(ok.error().kind, ErrorKind::bad_input);
    EXPECT_EQ(ok.error().message.rfind(path + ": cannot be read: ", 0), 0U) << ok.error().message;
  }
}

TEST(Config, AFileThatSetsNoKeyIsNoConfiguration) {
  const testing::TemporaryFolder folder;
  const std::string path = folder / "run.toml";
  for (const char* text : {"", "# population = 200\n", "[ga]\n"}) {
    std::ofstream(path) << text;
    EvolveConfig config;
    const auto ok = load_config(path, config);
    ASSERT_FALSE(ok.has_value()) << text;
    EXPECT_EQ(ok.error().kind, ErrorKind::bad_input);
    EXPECT_EQ(ok.error().message, path + ": sets no key: expected at least one, such as ga.population = 200");
  }
  std::ofstream(path) << "[fitness]\nrule = []\n";
  EvolveConfig config;
  EXPECT_TRUE(load_config(path, config).has_value()) << "taking all rules away is a setting";
}

TEST(Config, SettingsChangeOneKey) {
  EvolveConfig config;
  for (const char* assignment : {"ga.population=200", "seed=18446744073709551615", "fitness.return=0.25",
                                 "rollout.acting=policy", "ga.mutation=1", "fitness.size_weight=1e3"}) {
    const auto ok = apply_setting(assignment, config);
    ASSERT_TRUE(ok.has_value()) << ok.error().message;
  }
  EvolveConfig expected;
  expected.ga.population = 200;
  expected.seed = std::numeric_limits<std::uint64_t>::max();
  expected.fitness.expected_return = 0.25;
  expected.rollout.acting = Acting::policy;
  expected.ga.mutation = 1.0;
  expected.fitness.size_weight = 1000.0;
  EXPECT_EQ(config, expected);
}

TEST(Config, BadSettingsAreQuotedAndExplained) {
  const std::vector<BadFile> settings = {
      {"ga.population", {"--set ga.population: expected KEY=VALUE"}},
      {"ga.populaton=3", {"--set ga.populaton=3: ", "'populaton' in [ga]", "population"}},
      {"population=3", {"--set population=3: unknown key 'population': expected one of seed, [ga]"}},
      {"x.y=3", {"unknown key 'x.y'"}},
      {"ga.population=", {"ga.population is \"\": expected an integer"}},
      {"ga.population=12x", {"ga.population is \"12x\": expected an integer"}},
      {"ga.population=99999999999999999999999", {"expected an integer from 2 to 1000000"}},
      {"ga.crossover=half", {"ga.crossover is \"half\": expected a number from 0 to 1"}},
      {"ga.crossover=nan", {"expected a number from 0 to 1"}},
      {"fitness.rule=3", {"rules can be given only in a file"}},
      {"=3", {"unknown key ''"}},
      {"", {"expected KEY=VALUE"}},
  };
  for (const BadFile& setting : settings) {
    EvolveConfig config;
    const auto ok = apply_setting(setting.text, config);
    ASSERT_FALSE(ok.has_value()) << setting.text;
    EXPECT_EQ(ok.error().kind, ErrorKind::bad_input);
    for (const std::string& part : setting.says) {
      EXPECT_NE(ok.error().message.find(part), std::string::npos)
          << "'" << ok.error().message << "' does not say '" << part << "'";
    }
    EXPECT_EQ(config, EvolveConfig{});
  }
}

TEST(Config, IsCheckedAsAWhole) {
  const auto message = [](void (*change)(EvolveConfig&)) {
    EvolveConfig config;
    change(config);
    const auto ok = check_config(config, small_vocabulary());
    return ok ? std::string() : ok.error().message;
  };
  EXPECT_EQ(message([](EvolveConfig&) {}), "");
  EXPECT_EQ(message([](EvolveConfig& c) { c.ga.elites = 100; }),
            "ga.elites is 100: expected fewer than ga.population, which is 100");
  EXPECT_NE(message([](EvolveConfig& c) { c.rollout.steps = 1U << 20U; }).find("rollout.final_rollouts is 200"),
            std::string::npos);
  EXPECT_NE(message([](EvolveConfig& c) { c.fitness.agreement = 0; }).find("every weight is 0"), std::string::npos);
  EXPECT_NE(message([](EvolveConfig& c) { c.fitness.shaped = 1; }).find("s3, s4 and s5"), std::string::npos);
  EXPECT_NE(message([](EvolveConfig& c) {
              c.fitness.rules = {{{}, 1, 0}, {{"zz=3"}, 1, 0}};
            }).find("fitness.rule 2: 'zz=3'"),
            std::string::npos);
  EXPECT_NE(message([](EvolveConfig& c) {
              c.fitness.rules = {{{"left"}, 1, 0}};
            }).find("'left' is not a condition"),
            std::string::npos);
  EXPECT_NE(message([](EvolveConfig& c) { c.fitness.rules.resize(33); }).find("33 rules: expected at most 32"),
            std::string::npos);
}

TEST(Config, TheMethodAndItsGammaReachTheJob) {
  EvolveConfig config;
  config.rollout.gamma = 0.5;
  EXPECT_EQ(job_of(config, {Objective{}}, 3).gamma, 0U) << "the same job whatever an unused key says";
  ASSERT_TRUE(apply_setting("rollout.method=long_run", config).has_value());
  EXPECT_EQ(job_of(config, {Objective{}}, 3).method, Method::long_run);
  EXPECT_EQ(job_of(config, {Objective{}}, 3).gamma, 0U);
  ASSERT_TRUE(apply_setting("rollout.method=discounted", config).has_value());
  EXPECT_EQ(job_of(config, {Objective{}}, kFinalGeneration).method, Method::discounted);
  EXPECT_EQ(job_of(config, {Objective{}}, 3).gamma, std::uint64_t{1} << 63U);
  EXPECT_EQ(job_of(config, {Objective{}}, 3), job_of(config, {Objective{}}, kFinalGeneration));
  config.rollout.steps = kMaxSteps;
  EXPECT_TRUE(check_config(config, small_vocabulary()).has_value()) << "what is not walked has no limit to walks";
  EXPECT_TRUE(check_job(job_of(config, {Objective{}}, kFinalGeneration)).has_value());
}

TEST(Config, AMixedShareIsFixedPoint) {
  EvolveConfig config;
  config.rollout.acting = Acting::mixed;
  config.rollout.policy_share = 0.5;
  EXPECT_EQ(job_of(config, {Objective{}}, 3).policy_share, std::uint64_t{1} << 63U);
  config.rollout.policy_share = 1.0;
  EXPECT_EQ(job_of(config, {Objective{}}, 3).policy_share, std::numeric_limits<std::uint64_t>::max());
  config.rollout.policy_share = 0.0;
  EXPECT_EQ(job_of(config, {Objective{}}, 3).policy_share, 0U);
  config.rollout = {5, 100, 200, Acting::tree, 0.5};
  EXPECT_EQ(job_of(config, {Objective{}}, 3).policy_share, 0U) << "the same job whatever an unused key says";
}

}  // namespace
}  // namespace coppice
