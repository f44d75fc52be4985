// What is dispatched. A request is a row of units of work of one kind; a unit is known by its place in its request and
// has one outcome, a pure function of the unit, so that it does not matter who computes it, or how often. Nothing in
// the dispatcher looks into a unit or an outcome: it moves outcomes and compares them. Values.
#pragma once

#include <cstdint>
#include <variant>
#include <vector>

#include "common/fitness/job.hpp"

namespace coppice {

enum class WorkerId : std::uint64_t {};
enum class BatchId : std::uint64_t {};
enum class RequestId : std::uint64_t {};
enum class ComputeId : std::uint64_t {};

// In a batch's place of a worker: the coordinator itself.
inline constexpr WorkerId kHome{0};

// What sort of thing a unit is. Another kind needs an encoder, a decoder and a function that computes it (Work in
// coordinator/fleet), and nothing here.
enum class WorkKind : std::uint8_t {
  evaluate,  // a tree, to its tally
  evolve,    // an epoch of a deme, to the bytes of its result
};

// Units that cost about the same at one worker: their pace is measured together.
struct WorkClass {
  WorkKind kind = WorkKind::evaluate;
  std::uint64_t size = 0;  // of a unit, in whatever its kind counts; evaluate: walked steps; evolve: individuals
  bool operator==(const WorkClass&) const = default;
};

// A tally, or the bytes of any other result. Equal results have equal outcomes and the reverse.
using UnitOutcome = std::variant<Tally, std::vector<std::uint8_t>>;

struct Unit {
  RequestId request{};
  std::uint32_t index = 0;
  bool operator==(const Unit&) const = default;
};

// Units first .. first + count - 1 of a request, as they go to one worker in one message.
struct Batch {
  BatchId id{};
  RequestId request{};
  std::uint32_t first = 0;
  std::uint32_t count = 0;
};

}  // namespace coppice
