// A study of the small world that was never learned in a room: chain, one run with its generations.
#pragma once

#include "coordinator/learning/world.hpp"
#include "coordinator/studio/page_data.hpp"
#include "coordinator/study/study.hpp"
#include "tests/coordinator/evolution/small_world.hpp"
#include "tests/temporary_folder.hpp"

namespace coppice::testing {

struct StudioStudy {
  TemporaryFolder folder;
  std::string path = folder / "small.coppice";
  Study study = *Study::create(path, small_chain(), {kNoWorld, ""},
                               {R"({"world":"small","episodes":10})", R"({"curve":{"episodes_per_point":5}})"});

  static PageRequest request(const Tree& tree) {
    return {.tree = tree,
            .tree_from = "run 1",
            .simulate = {.episodes = 10, .steps = 30, .seed = 1},
            .resamples = 20,
            .rules = {"never none", "never move when a=0", "nonsense"},
            .machine = "a machine",
            .command = "coppice report small.coppice -o small.html"};
  }
};

}  // namespace coppice::testing
