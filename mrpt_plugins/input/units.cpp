// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/units.h"

#include <cmath>

#include "libhybrid/uncertainty/sensor_alignment.h"

namespace hybrid {
namespace {

constexpr double kWheelError = 0.05;  // share: slip, tyres, a wheelbase that is not measured well

bool is_unit(double ratio, double in_ours) {
  return std::abs(std::abs(std::log(ratio)) + std::log(in_ours)) < kWheelError;
}

}  // namespace

std::string length_unit(double ratio) {
  for (const LengthUnit& unit : kLengthUnits) {
    if (is_unit(ratio, unit.metres)) return unit.name;
  }
  return "";
}

std::string angle_unit(double ratio) {
  return is_unit(ratio, M_PI / 180) ? "degrees" : "";
}

}  // namespace hybrid
