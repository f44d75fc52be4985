// What `coppice bench` prints: tables for people as the measurements come in, and one JSON object for programs.
#pragma once

#include <string>
#include <vector>

#include "coordinator/bench/machine.hpp"
#include "coordinator/bench/pacing.hpp"
#include "coordinator/bench/scaling.hpp"
#include "coordinator/bench/transfer.hpp"

namespace coppice {

std::string to_text(const Machine& machine);
std::string to_text(const WorkloadScaling& scaling);
// From which workload on how many workers pay, in a sentence for each number of them, and what the columns mean.
std::string verdict(const std::vector<WorkloadScaling>& scaling, unsigned cores);

std::string to_text(const Transfer& transfer);

std::string pacing_heading(const PacingSettings& settings);
std::string to_text(const PacingRow& row);

// One line.
std::string to_json(const Machine& machine, const ScalingSettings& settings,
                    const std::vector<WorkloadScaling>& scaling);
std::string to_json(const Machine& machine, const TransferSettings& settings, const Transfer& transfer);
std::string to_json(const Machine& machine, const PacingSettings& settings, const std::vector<PacingRow>& rows);

}  // namespace coppice
