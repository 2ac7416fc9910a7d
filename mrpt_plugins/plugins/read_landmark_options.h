// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <vector>

#include "libhybrid/detections/class_model.h"
#include "libhybrid/initialization/gaussian_sum_initializer.h"
#include "libhybrid/landmarks/association_options.h"
#include "mrpt_plugins/bridge/ini_file.h"

/// Readers of the options of landmark plugins, from the section of a plugin. All throw Error as
/// IniFile does.
namespace HYBRID_API hybrid {

/// `sensors`: the labels of the sensors to use; empty: all.
std::vector<std::string> read_sensors(IniSection& section);

/// `class_names`, `class_prior`, `confusion` and `score_floor`, which must be consistent.
ClassModel read_class_model(IniSection& section);

AssociationOptions read_association_options(IniSection& section);

/// Options of landmarks that no single measurement determines.
BankOptions read_bank_options(IniSection& section);

}  // namespace hybrid
