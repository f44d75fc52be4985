// What the thesis prints: Y.S. Janssen, "Reinforcement Learning Policy Approximation by Behavior Trees using Genetic
// Algorithms", TU Delft, 2016. Cells are quoted as they stand, mistakes included; each block names its table and
// section.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace coppice::printed {

// Two columns: Q-learning, and the tree.
struct TwoColumns {
  std::string_view q_score_policy, q_score_tree;  // empty: the table has no such row
  std::string_view all_policy, all_tree;          // "Action-selection for all states"
  std::string_view simulation_policy, simulation_tree;
  std::string_view reward_policy, reward_tree;
  std::string_view entries, nodes;
};

// Table IV, Part I, VI-E.4: columns Q-learning, BT, BT adjusted.
inline constexpr std::array<std::string_view, 3> kFourAll{"100", "66 %", "86 %"};
inline constexpr std::array<std::string_view, 3> kFourSimulation{"100", "93 %", "96 %"};
inline constexpr std::array<std::string_view, 3> kFourReward{"283", "248", "266"};
inline constexpr std::array<std::string_view, 3> kFourSize{"3123-entries", "6 nodes", "20 nodes"};

// Table 5-1, section 5-1-1.
inline constexpr TwoColumns kFiveOne{"3237", "6324", "50%", "89%",          "100 %",
                                     "86%",  "283",  "48",  "3123 entries", "91 nodes"};
// Table 5-2, section 5-1-1.
inline constexpr TwoColumns kFiveTwo{"3237", "10124", "100 %", "52 %",         "100 %",
                                     "50%",  "298",   "-150",  "3123 entries", "90 nodes"};
// Table 5-6, section 5-1-2.
inline constexpr TwoColumns kFiveSix{"", "", "100 %", "34 %", "100 %", "93%", "298", "159", "3123 entries", "17 nodes"};
// Table 5-7, section 5-2-1.
inline constexpr TwoColumns kFiveSeven{"",     "",    "100 %", "82 %",         "100 %",
                                       "49 %", "260", "-484",  "3123 entries", "9 nodes"};

// Table 5-8, section 5-2-1: ten runs.
inline constexpr std::array<std::string_view, 10> kFiveEightReward{"107",   "145",   "147",   "38",   "-1212",
                                                                   "-1034", "-1034", "-1014", "-974", "159"};
inline constexpr std::array<std::string_view, 10> kFiveEightSuccess{"88%", "85%", "87%", "79%", "16%",
                                                                    "25%", "25%", "24%", "24%", "85%"};

// Table 5-3, section 5-1-1: Q-values of three states; move, turn left, turn right.
struct StateValues {
  std::array<std::uint8_t, 8> sensors;
  std::array<std::string_view, 3> values;
};
inline constexpr std::array<StateValues, 3> kFiveThree{{
    {{1, 1, 1, 1, 1, 1, 1, 1}, {"7.6659", "0.728183", "0.580431"}},
    {{1, 1, 1, 3, 1, 1, 1, 1}, {"14.301", "4.88565", "6.2666"}},
    {{1, 1, 1, 1, 1, 3, 1, 1}, {"1.28739", "4.72524", "20.7678"}},
}};

// Table 5-4, section 5-1-1: moving forward from (1,1,1,3,1,1,1,1).
struct Successor {
  std::array<std::uint8_t, 8> sensors;
  std::string_view transitions;
  std::string_view probability;
};
inline constexpr std::array<std::uint8_t, 8> kTrashAhead{1, 1, 1, 3, 1, 1, 1, 1};
inline constexpr std::array<Successor, 9> kFiveFour{{
    {{0, 0, 0, 1, 1, 1, 1, 1}, "298", "0.7 %"},
    {{1, 1, 1, 1, 1, 1, 1, 1}, "32683", "78.0 %"},
    {{1, 1, 1, 1, 3, 1, 1, 1}, "527", "1.0 %"},
    {{0, 1, 1, 1, 1, 1, 1, 1}, "6258", "15 %"},
    {{1, 1, 1, 1, 1, 1, 3, 1}, "1296", "3.0 %"},
    {{1, 1, 1, 1, 0, 1, 1, 1}, "299", "0.7 %"},
    {{0, 1, 1, 1, 1, 1, 3, 1}, "31", "0.0 %"},
    {{1, 1, 1, 1, 1, 1, 0, 1}, "235", "0.6 %"},
    {{0, 1, 1, 1, 3, 1, 1, 1}, "37", "0.0 %"},
}};

// Part I, VII "Easy verification": 488 states with a wall on s3, hence 1464 state-action values, against 4 nodes. The
// abstract has 1448 values and 3 nodes for the same.
inline constexpr std::string_view kWallStates = "488";
inline constexpr std::string_view kWallValues = "1464";
inline constexpr std::string_view kWallNodes = "4";

// Table 4-1 and section 4-1: columns Q-learning, SARSA.
inline constexpr std::array<std::string_view, 2> kGridEpisodes{"200", "200"};
inline constexpr std::array<std::string_view, 2> kGridConverged{"198", "269"};
inline constexpr std::array<std::string_view, 2> kGridGamma{"0.8", "0.9"};
inline constexpr std::array<std::string_view, 2> kGridReward{"-13", "-13"};
inline constexpr std::string_view kGridNodes = "9 nodes";        // section 4-2, Figure 4-4a
inline constexpr std::string_view kGridEntries = "320 entries";  // section 4-2

}  // namespace coppice::printed
