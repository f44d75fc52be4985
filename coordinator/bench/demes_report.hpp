// What `coppice bench --demes` prints: tables for people as the measurements come in, and one JSON object for programs.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "coordinator/bench/demes.hpp"
#include "coordinator/bench/paced_demes.hpp"
#include "coordinator/bench/pacing.hpp"

namespace coppice {

std::string to_text(const DemeScaling& scaling);
std::string to_text(const DemeScaling& scaling, const Hosts& hosts, const DemePlan& plan);
std::string paced_demes_heading(const PacingSettings& settings);
std::string to_text(const PacedDemesRow& row);
// One line.
std::string to_json(const PacingSettings& settings, const std::vector<PacedDemesRow>& rows);
// One line; with a plan for each workload where hosts are given.
std::string to_json(const ScalingSettings& settings, const std::vector<DemeScaling>& scaling,
                    const std::optional<Hosts>& hosts);

}  // namespace coppice
