// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/job/replay.h"

#include <pybind11/functional.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <nlohmann/json.hpp>
#include <optional>

#include "libhybrid/core/version.h"
#include "mrpt_plugins/mapping/plugin_library.h"

namespace py = pybind11;
using namespace pybind11::literals;

namespace {

using Progress = std::function<void(std::optional<double>, std::size_t, std::size_t, double)>;

/// Runs a replay without the lock of the interpreter and returns the text of summary.json. Acquires
/// the lock to call `progress` and to check for Ctrl-C.
std::string replay(hybrid::ReplayRequest request, const std::vector<std::string>& command,
                   const std::optional<Progress>& progress) {
  request.provenance.version = std::string(hybrid::kVersion);
  request.provenance.command = command;
  const auto watch = [&](const hybrid::ReplayProgress& so_far) {
    const py::gil_scoped_acquire lock;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (progress) {
      (*progress)(so_far.fraction, so_far.keyframes, so_far.landmarks, so_far.objective);
    }
  };
  const py::gil_scoped_release unlocked;
  for (const std::string& path : request.plugin_libraries) hybrid::load_plugin_library(path);
  return hybrid::summary_json(hybrid::replay(request, watch).summary)
      .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

PYBIND11_MODULE(_mrpt, m) {
  py::module_::import("hybrid._core");  // it translates Error into a Python exception
  m.def(
      "replay",
      [](const std::string& config, const std::string& output, const std::string& rawlog,
         const std::string& truth_path, const std::string& truth_map,
         const std::vector<std::string>& settings, const std::vector<std::string>& plugins,
         bool pictures, const std::vector<std::string>& command,
         const std::optional<Progress>& progress) {
        hybrid::ReplayRequest request;
        request.config = config;
        request.output = output;
        request.rawlog = rawlog;
        request.truth_path = truth_path;
        request.truth_map = truth_map;
        request.settings = settings;
        request.plugin_libraries = plugins;
        request.pictures = pictures;
        return replay(std::move(request), command, progress);
      },
      "config"_a, "output"_a, "rawlog"_a, "truth_path"_a, "truth_map"_a, "settings"_a, "plugins"_a,
      "pictures"_a, "command"_a, "progress"_a);
}
