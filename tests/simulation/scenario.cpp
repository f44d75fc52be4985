#include "tests/simulation/scenario.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "tests/simulation/dice.hpp"

namespace coppice::simulation {
namespace {

constexpr std::array<const char*, Fault::kKinds> kNames = {
    "crash",       "pause",          "slow",         "cut_off",     "all_cut_off", "all_crash",           "leave",
    "hang",        "forget_chain",   "lack_memory",  "lie",         "damage",      "coordinator_held_up", "abandon",
    "false_hello", "false_farewell", "false_answer", "fake_worker", "other_build", "deadly_unit"};

// Each kind is in a run or not, and those that are have weights of their own: a run without restarts, or of liars
// alone, reaches what an average run never does.
std::array<std::uint32_t, Fault::kKinds> weights(Dice& dice) {
  std::array<std::uint32_t, Fault::kKinds> weights{};
  const std::uint64_t share = dice.between(1, 4);  // quarters of the kinds
  for (std::uint32_t& weight : weights) {
    weight = dice.below(4) < share ? static_cast<std::uint32_t>(dice.of_any_size(1, 64)) : 0;
  }
  return weights;
}

Fault fault_of(Fault::Kind kind, Nanos within, Dice& dice) {
  using Kind = Fault::Kind;
  Fault fault{.kind = kind,
              .at = static_cast<Nanos>(dice.below(static_cast<std::uint64_t>(within))),
              .lasts = static_cast<Nanos>(dice.of_any_size(kMillisecond, 20 * kSecond)),
              .target = static_cast<std::uint32_t>(dice.below(1U << 20U)),
              .detail = static_cast<std::uint32_t>(dice.below(4))};
  switch (kind) {
    case Kind::slow:
      fault.detail = static_cast<std::uint32_t>(dice.of_any_size(2, 1000));
      break;
    case Kind::all_cut_off:
    case Kind::all_crash:
      fault.lasts = dice.one_in(64) ? 3600 * kSecond : fault.lasts;
      break;
    case Kind::lack_memory:
      fault.detail = static_cast<std::uint32_t>(dice.below(8));
      break;
    default:
      break;
  }
  return fault;
}

// Everybody dies again and again, until units travel alone; then, often while these still wait, all is given up.
void add_deaths_in_a_row(Scenario& scenario, Nanos within, Dice& dice) {
  auto at = static_cast<Nanos>(dice.below(static_cast<std::uint64_t>(within)));
  for (std::uint64_t deaths = dice.between(1, 4); deaths > 0; --deaths) {
    scenario.faults.push_back({.kind = Fault::Kind::all_crash, .at = at, .lasts = kMillisecond});
    at += 20 * kMillisecond + static_cast<Nanos>(dice.below(300 * kMillisecond));
    if (dice.one_in(2)) {
      at = scenario.faults.back().at + static_cast<Nanos>(dice.of_any_size(20 * kMillisecond, 2 * kSecond));
    }
  }
  if (dice.one_in(2)) {
    at = scenario.faults.back().at + static_cast<Nanos>(dice.of_any_size(kMillisecond, 200 * kMillisecond));
    scenario.faults.push_back({.kind = Fault::Kind::abandon, .at = at});
  }
}

}  // namespace

std::string in_words(const Fault& fault) {
  return fmt::format("{} at {:.3f} s for {:.3f} s, worker {}, detail {}", kNames[static_cast<std::size_t>(fault.kind)],
                     static_cast<double>(fault.at) / kSecond, static_cast<double>(fault.lasts) / kSecond, fault.target,
                     fault.detail);
}

Scenario scenario_of(std::uint64_t seed) {
  Dice dice(hash(seed, 1));
  Scenario scenario;
  scenario.seed = seed;
  // Most runs are small: what goes wrong with a thousand workers mostly goes wrong with three.
  const std::uint64_t size = dice.below(1000);
  scenario.workers = static_cast<std::uint32_t>(size < 960   ? dice.between(1, 6)
                                                : size < 999 ? dice.of_any_size(4, 64)
                                                             : dice.of_any_size(64, 1000));
  scenario.lanes = dice.one_in(4) ? static_cast<std::uint32_t>(dice.between(2, 4)) : 1;
  scenario.own_processes = dice.one_in(2) && scenario.workers <= 64;
  scenario.guests = scenario.own_processes && dice.one_in(3) ? static_cast<std::uint32_t>(dice.between(1, 3)) : 0;
  scenario.at_once = dice.one_in(4);
  scenario.clients = dice.one_in(4) ? static_cast<std::uint32_t>(dice.between(2, 16)) : 1;
  scenario.demes = dice.one_in(4) ? static_cast<std::uint32_t>(dice.between(1, scenario.clients)) : 0;
  scenario.epoch = static_cast<std::uint32_t>(dice.of_any_size(1, 64));
  scenario.units = static_cast<std::uint32_t>(size < 960   ? dice.of_any_size(1, 32)
                                              : size < 998 ? dice.of_any_size(16, 1000)
                                                           : dice.of_any_size(1000, 100'000));
  const std::uint64_t work = 4000 / (scenario.units + 8);
  scenario.requests = static_cast<std::uint32_t>(std::max<std::uint64_t>(dice.of_any_size(1, 256) * work / 64, 1));
  if (scenario.units > 1000) {
    scenario.clients = std::min(scenario.clients, 2U);
  }
  scenario.requests = std::max(scenario.requests / scenario.clients, 1U);
  scenario.portions = dice.one_in(3) ? static_cast<std::uint32_t>(dice.between(2, 4)) : 1;
  scenario.each = static_cast<Nanos>(dice.of_any_size(kMicrosecond, 50 * kMillisecond));
  scenario.delay = static_cast<Nanos>(dice.of_any_size(5 * kMicrosecond, 2 * kMillisecond));
  scenario.lost = dice.one_in(3) ? static_cast<std::uint32_t>(dice.of_any_size(10, 50'000)) : 0;
  scenario.doubled = dice.one_in(3) ? static_cast<std::uint32_t>(dice.of_any_size(10, 300'000)) : 0;
  scenario.cross_check = dice.one_in(2) ? 0 : dice.one_in(2) ? 1000 : static_cast<std::uint32_t>(dice.between(1, 300));

  if (dice.one_in(2)) {
    scenario.ahead = static_cast<std::uint32_t>(dice.below(4));
    scenario.copies = static_cast<std::uint32_t>(dice.between(1, 3));
    scenario.isolate_after = static_cast<std::uint32_t>(dice.between(1, 3));
    scenario.apart_after = scenario.isolate_after + static_cast<std::uint32_t>(dice.below(5));
    scenario.lost_before_apart = static_cast<std::uint32_t>(dice.between(1, 8));
  }

  // Faults fall within the time that the work should take, so that they hit it.
  const double ideal = static_cast<double>(scenario.total_requests()) *
                       (static_cast<double>(scenario.units) * static_cast<double>(scenario.each) / scenario.workers +
                        4.0 * static_cast<double>(scenario.delay));
  const auto within = static_cast<Nanos>(std::clamp(ideal, 1e7, 2e10));
  const auto weight = weights(dice);
  std::uint32_t total = 0;
  for (const std::uint32_t one : weight) {
    total += one;
  }
  const std::uint64_t count = dice.one_in(8) || total == 0 ? 0 : dice.of_any_size(1, 16);
  for (std::uint64_t i = 0; i < count; ++i) {
    auto pick = static_cast<std::uint32_t>(dice.below(total));
    int kind = 0;
    while (pick >= weight[static_cast<std::size_t>(kind)]) {
      pick -= weight[static_cast<std::size_t>(kind)];
      ++kind;
    }
    Fault fault = fault_of(static_cast<Fault::Kind>(kind), within, dice);
    if (!scenario.faults.empty() && dice.one_in(2)) {  // trouble comes to whom there is trouble already
      const Fault& other = scenario.faults[dice.below(scenario.faults.size())];
      fault.target = other.target;
      fault.at = other.at + static_cast<Nanos>(dice.below(static_cast<std::uint64_t>(other.lasts) + 1));
    }
    scenario.faults.push_back(fault);
  }
  if (dice.one_in(8)) {
    add_deaths_in_a_row(scenario, within, dice);
  }
  return scenario;
}

Scenario arrival_of(std::uint32_t workers) {
  Scenario scenario;
  scenario.seed = workers;
  scenario.workers = workers;
  scenario.at_once = true;
  scenario.units = 10 * workers;
  scenario.each = 50 * kMillisecond;  // the last are there before it is done
  return scenario;
}

std::string command_of(const Scenario& scenario, const std::string& mutation) {
  const Scenario whole = scenario_of(scenario.seed);
  std::vector<std::size_t> kept;
  std::size_t next = 0;
  for (const Fault& fault : scenario.faults) {
    while (next < whole.faults.size() && in_words(whole.faults[next]) != in_words(fault)) {
      ++next;
    }
    kept.push_back(next++);
  }
  std::string command = fmt::format("simulate --seed {}", scenario.seed);
  const auto add = [&](const char* flag, auto value, auto original) {
    command += value == original ? "" : fmt::format(" --{} {}", flag, value);
  };
  add("workers", scenario.workers, whole.workers);
  add("guests", scenario.guests, whole.guests);
  add("clients", scenario.clients, whole.clients);
  add("demes", scenario.demes, whole.demes);
  add("requests", scenario.requests, whole.requests);
  add("units", scenario.units, whole.units);
  if (kept.size() != whole.faults.size()) {
    command += kept.empty() ? " --faults none" : fmt::format(" --faults {}", fmt::join(kept, ","));
  }
  return command + (mutation.empty() ? "" : " --mutation " + mutation);
}

}  // namespace coppice::simulation
