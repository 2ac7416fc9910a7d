// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <iostream>

#include "mrpt_plugins/output/trajectory_writer.h"

int main() {
  const hybrid::Trajectory trajectory{{1.0, mrpt::poses::CPose3D(1, 2, 3, 0, 0, 0)}};
  const std::string text = hybrid::tum_text(trajectory);
  std::cout << text;
  return text.empty() ? 1 : 0;
}
