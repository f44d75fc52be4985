// What one step in a simulator gave, whichever the world. A plain value.
#pragma once

namespace coppice {

struct Outcome {
  double reward = 0.0;
  bool collided = false;
  bool ended = false;  // the episode is over: nothing is earned from here on
};

}  // namespace coppice
