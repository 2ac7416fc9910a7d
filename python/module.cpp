// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/core/version.h"
#include "python/bindings.h"
#include "python/pickle.h"

namespace {

/// What pybind11 calls where an object has no value yet, as one that `cls.__new__(cls)` or a
/// damaged pickle made. Its own answer is memory that nobody has initialised.
void* refuse_empty_object(std::size_t /*size*/) {
  throw pybind11::type_error("the object has no value: its __init__ was not called");
}

/// Lets all methods and functions refuse objects of these classes that have no value.
void refuse_empty_objects(const pybind11::module_& m) {
  for (const auto& [name, value] : pybind11::dict(m.attr("__dict__"))) {
    if (PyType_Check(value.ptr()) == 0) continue;
    auto* type = reinterpret_cast<PyTypeObject*>(value.ptr());
    if (auto* bound = pybind11::detail::get_type_info(type)) {
      bound->operator_new = &refuse_empty_object;
    }
  }
}

}  // namespace

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
  refuse_empty_objects(m);
  m.attr("__version__") = hybrid::kVersion;
}
