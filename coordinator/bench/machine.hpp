// The machine that a measurement was made on, as far as its figures depend on it.
#pragma once

#include <string>

namespace coppice {

struct Machine {
  std::string processor;  // as the system names it
  unsigned cores = 1;     // that this process may use
  std::string system;     // distribution and kernel
  double load = 0.0;      // runnable threads, mean of the last minute
};

Machine this_machine();

}  // namespace coppice
