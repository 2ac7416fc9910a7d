// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/objects/object_map.h"
#include "mrpt_plugins/bridge/provenance.h"

namespace hybrid {

/// One sequence with the result of each method: the start, switches, Huber, Cauchy.
struct ObjectReport {
  struct Answer {
    RobustResult result;
    std::optional<ObjectMapErrors> errors;  ///< if the truth is known
  };
  std::string name;
  ObjectSequence sequence;
  ObjectNoise stated, noise;  ///< and what is used
  RobustProblem problem;
  std::vector<Answer> answers;
};

/// Reads and solves a sequence by all methods, with its noise as it is measured or as it is stated.
/// Throws Error for bad input.
ObjectReport solve_sequence(const std::string& name, const std::string& folder, bool measured);

/// Errors by sequence and method, as a text table.
std::string comparison_table(const std::vector<ObjectReport>& reports);

/// What was measured of the noise of each sequence, one line for each.
std::string noise_lines(const std::vector<ObjectReport>& reports);

/// Adds the files of a sequence to the inputs.
void add_sequence(const std::string& folder, Provenance& provenance);

/// Writes summary.json and, in a folder per sequence, objects.csv, trajectory.tum, objects.png.
/// Fixes (see `settle`) and returns the exit code: that of a partial result if our own method did
/// not converge.
int write_reports(const std::vector<ObjectReport>& reports, const std::filesystem::path& output,
                  const Provenance& provenance);

}  // namespace hybrid
