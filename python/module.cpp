// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/core/version.h"
#include "python/bindings.h"
#include "python/pickle.h"

PYBIND11_MODULE(_core, m) {
  using namespace hybrid::python;
  bind_core(m);
  bind_geometry(m);
  bind_values(m);
  bind_factors(m);
  bind_discrete(m);
  bind_hybrid(m);
  bind_solvers(m);
  bind_marginals(m);
  bind_smoother(m);
  bind_pose_graph(m);
  bind_selection(m);
  bind_registration(m);
  bind_landmarks(m);
  bind_pickle(m);
  m.attr("__version__") = hybrid::kVersion;
}
