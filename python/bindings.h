// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <memory>
#include <string>
#include <vector>

#include "libhybrid/core/values.h"
#include "libhybrid/factors/factor.h"

namespace hybrid::python {

namespace py = pybind11;
using namespace pybind11::literals;

/// Releases the lock of the interpreter (GIL) in functions that take long, so that other Python
/// threads can run; for arguments that nobody can change meanwhile (see calls.h for others).
/// Factors written in Python acquire it for their calls, also from threads of the solver.
using Unlocked = py::call_guard<py::gil_scoped_release>;

// One function per room of the library. A room binds its classes after the classes that they use.
void bind_geometry(py::module_& m);
void bind_core(py::module_& m);
void bind_values(py::module_& m);
void bind_factors(py::module_& m);
void bind_python_factor(py::module_& m);
void bind_discrete(py::module_& m);
void bind_hybrid(py::module_& m);
void bind_mixtures(py::module_& m);
void bind_solvers(py::module_& m);
void bind_marginals(py::module_& m);
void bind_smoother(py::module_& m);
void bind_pose_graph(py::module_& m);
void bind_selection(py::module_& m);
void bind_registration(py::module_& m);
void bind_landmarks(py::module_& m);

/// A value of a variable as a Python object: SO2, SE2, SO3, SE3 or an array of numbers.
py::object value_of(VariableType type, const double* x);

/// The variable type of a class (SO2, SE2, SO3, SE3) or of a vector length. Throws Error for
/// anything else.
VariableType type_of(const py::handle& type);

/// The inverse of type_of().
py::object to_python(VariableType type);

/// Conversions between arrays of n x 3 numbers and point clouds.
using PointArray = py::array_t<double, py::array::c_style | py::array::forcecast>;
std::vector<Eigen::Vector3d> to_points(const PointArray& array);
PointArray to_array(const std::vector<Eigen::Vector3d>& points);

/// A factor passed from Python. A factor written in Python keeps its Python object alive as long as
/// the pointer is held.
struct FactorArgument {
  ContinuousFactorPtr pointer;
};

/// The pointers of several factors.
std::vector<ContinuousFactorPtr> to_pointers(const std::vector<FactorArgument>& factors);

/// The Python object that the pointer to a factor keeps alive; null for a factor of the library.
PyObject* python_object(const ContinuousFactorPtr& factor);

/// The pointer to a Python object that is a continuous factor; null for other objects.
ContinuousFactorPtr factor_pointer(py::handle object);

}  // namespace hybrid::python

namespace pybind11::detail {

template <>
struct type_caster<hybrid::python::FactorArgument> {
  PYBIND11_TYPE_CASTER(hybrid::python::FactorArgument, const_name("hybrid._core.ContinuousFactor"));

  bool load(handle source, bool) {
    value.pointer = hybrid::python::factor_pointer(source);
    return value.pointer != nullptr;
  }
};

}  // namespace pybind11::detail
