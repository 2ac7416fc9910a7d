// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/units.h"

#include <cmath>

namespace hybrid {
namespace {

constexpr double kWheelError = 0.05;  // share: slip, tyres, a wheelbase that is not measured well

bool is_unit(double ratio, double in_ours) {
  return std::abs(std::abs(std::log(ratio)) + std::log(in_ours)) < kWheelError;
}

}  // namespace

std::string length_unit(double ratio) {
  if (is_unit(ratio, 0.3048)) return "feet";
  if (is_unit(ratio, 0.0254)) return "inches";
  if (is_unit(ratio, 0.01)) return "centimetres";
  return is_unit(ratio, 0.001) ? "millimetres" : "";
}

std::string angle_unit(double ratio) {
  return is_unit(ratio, M_PI / 180) ? "degrees" : "";
}

}  // namespace hybrid
