// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Files that tell what is true, and other small tables; the first byte chooses the reader.

#include "libhybrid/io/read_pairs.h"
#include "libhybrid/objects/object_sightings.h"
#include "mrpt_plugins/evaluation/association_truth.h"
#include "mrpt_plugins/evaluation/graph_truth.h"
#include "mrpt_plugins/evaluation/ground_truth.h"
#include "mrpt_plugins/evaluation/mode_truth.h"
#include "mrpt_plugins/evaluation/mover_truth.h"
#include "tests/fuzz/targets/fuzz_input.h"

using namespace hybrid;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::Folder folder;
  static const std::string objects =
      folder.write("odom.txt", "0 0 0 0 0 0 0 1\n0.1 1 0 0 0 0 0 1\n");
  fuzz::Input input(data, size);
  const std::size_t reader = input.choose(12);
  const char* name = reader == 1 ? "a.tum" : reader == 9 ? "det_cup.txt" : "a.txt";
  const std::string path = folder.write(name, input.rest());
  fuzz::allow_error([&] {
    switch (reader) {
      case 0:
        return void(read_true_landmarks(path));
      case 1:
        return void(read_tum(path));
      case 2:
        return void(read_true_path(path));
      case 3:
        return void(read_positions(path));
      case 4:
        return void(read_true_modes(path));
      case 5:
        return void(read_true_associations(path));
      case 6:
        return void(read_pairs(path, true));
      case 7:
        return void(read_true_poses(path, "", {Key('x', 0), Key('x', 1)}));
      case 8:
        return void(read_true_poses(path, path, {Key('x', 0)}));
      case 10:
        return void(read_true_movers(path));
      case 11:
        return void(read_true_fixes(path));
      default:
        return void(read_object_sequence(std::filesystem::path(path).parent_path()));
    }
  });
  return 0;
}
