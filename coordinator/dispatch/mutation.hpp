// Faults that the simulation puts into the dispatcher, one at a time, to show that it would find them. Compiled in by
// COPPICE_MUTATIONS, which only the simulation's own build of these sources defines; elsewhere every COPPICE_MUTATED is
// false, and nothing is left of it.
#pragma once

#ifdef COPPICE_MUTATIONS
#include <array>
#include <string>

namespace coppice {

enum class Mutation : int {
  none,
  lost_units_invented,     // a unit that was with five workers that went out of reach counts as settled
  losses_count_as_deaths,  // out of reach is taken for dead
  anybody_may_say_farewell,
  anybody_keeps_alive,   // with Hellos in a worker's name
  names_are_forgotten,   // when their worker goes: the next to say it has it
  silence_while_absent,  // counts against workers though the coordinator did not listen
  isolated_units_starve,
  batch_numbers_again,  // after an abandoned run they begin at 1: late answers of earlier runs fit
  duplicates_counted_twice,
  credit_never_returned,
  lost_batches_forgotten,
  given_back_forgotten,
  liars_words_stay,
  short_memory_asked_again,
  deadly_units_go_on,  // the death of the process apart is taken for an answer of nothing
  growing_requests_end_early,
  foreign_processes_are_ours,   // a process number alone says which worker ended
  samples_not_waited_for,       // a request is done while what was said in it is being computed again
  isolation_outlives_requests,  // the count of units that travel alone forgets those that were given up
};

inline constexpr std::array kMutationNames = {
    "none",
    "lost_units_invented",
    "losses_count_as_deaths",
    "anybody_may_say_farewell",
    "anybody_keeps_alive",
    "names_are_forgotten",
    "silence_while_absent",
    "isolated_units_starve",
    "batch_numbers_again",
    "duplicates_counted_twice",
    "credit_never_returned",
    "lost_batches_forgotten",
    "given_back_forgotten",
    "liars_words_stay",
    "short_memory_asked_again",
    "deadly_units_go_on",
    "growing_requests_end_early",
    "foreign_processes_are_ours",
    "samples_not_waited_for",
    "isolation_outlives_requests",
};

extern Mutation active_mutation;
// False: no such name.
bool set_mutation(const std::string& name);

}  // namespace coppice

#define COPPICE_MUTATED(name) (::coppice::active_mutation == ::coppice::Mutation::name)
#else
#define COPPICE_MUTATED(name) false
#endif
