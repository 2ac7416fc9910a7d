// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// INI files: what the mapping reads of them, and the same from what it documents.

#include "mrpt_plugins/bridge/ini_file.h"
#include "mrpt_plugins/input/keyframe_source.h"
#include "mrpt_plugins/mapping/backend.h"
#include "mrpt_plugins/mapping/calibration.h"
#include "mrpt_plugins/mapping/mapping_plugin.h"
#include "mrpt_plugins/mapping/motion.h"
#include "mrpt_plugins/simulation/scenario.h"
#include "tests/fuzz/targets/fuzz_input.h"

using namespace hybrid;

namespace {

void read_mapping(IniFile& ini) {
  read_source_options(ini);
  read_motion_options(ini);
  read_calibration_options(ini);
  make_backend(ini.section("solver"));
  for (const std::string& name : registered_plugins()) make_plugin(name, ini);
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  fuzz::allow_error([&] { IniFile(text, "ini").reject_unknown(); });
  fuzz::allow_error([&] {
    IniFile ini(text, "ini");
    read_scenario(ini);
  });
  fuzz::allow_error([&] {
    IniFile ini(text, "ini");
    read_mapping(ini);
    const std::string documented = ini.documentation();
    IniFile again(documented, "documented");
    read_mapping(again);
    fuzz::expect(again.documentation() == documented);
  });
  return 0;
}
