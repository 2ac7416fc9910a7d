// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Point clouds; the first byte chooses the format.

#include "libhybrid/io/read_points.h"
#include "tests/fuzz/targets/fuzz_input.h"

using namespace hybrid;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::Folder folder;
  constexpr const char* kNames[] = {"a.xyz", "a.csv", "a.ply", "a.pcd"};
  fuzz::Input input(data, size);
  const std::string path = folder.write(kNames[input.choose(4)], input.rest());
  fuzz::allow_error([&] {
    const PointFile file = read_points(path);
    fuzz::expect(!file.points.empty());
    fuzz::expect(file.times.empty() || file.times.size() == file.points.size());
    for (const Eigen::Vector3d& p : file.points) {
      fuzz::expect(p.allFinite() && p.cwiseAbs().maxCoeff() <= 1e15);
    }
  });
  return 0;
}
