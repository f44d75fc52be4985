// The input that a fuzz target is at, shown on standard error whatever stops the program: a broken property, an
// exception that nobody caught, a signal, a sanitizer's verdict, a stall. One for the process; one thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace coppice::fuzz {

// From now on. With a sanitizer memory faults are left to it: it says more, and calls us before it ends the process.
void show_last_input_when_stopped();

// What is shown; both must stay as they are until it is forgotten. `origin` is how to run it again.
void set_last_input(const std::string& origin, const std::uint8_t* data, std::size_t size);
void forget_last_input();

// Ends the process, showing the input, unless it is called again within kStall.
void expect_progress();
inline constexpr unsigned kStall = 300;  // seconds; thousands of inputs take less, with sanitizers too

}  // namespace coppice::fuzz
