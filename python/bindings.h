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

/// Of everything that evaluates factors or solves: other Python threads run meanwhile. Factors
/// written in Python take the lock again for their calls, from the threads of the solver too.
using Unlocked = py::call_guard<py::gil_scoped_release>;

// One for each room of the library; a room binds its classes after those that they name.
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

/// A value of a variable as Python sees it: SO2, SE2, SO3, SE3 or an array of numbers.
py::object value_of(VariableType type, const double* x);

/// The type that a class (SO2, SE2, SO3, SE3), or the length of a vector, stands for. Throws Error
/// for anything else.
VariableType type_of(const py::handle& type);

/// The reverse of type_of.
py::object to_python(VariableType type);

/// A cloud from an array of n x 3 numbers and back.
using PointArray = py::array_t<double, py::array::c_style | py::array::forcecast>;
std::vector<Eigen::Vector3d> to_points(const PointArray& array);
PointArray to_array(const std::vector<Eigen::Vector3d>& points);

/// A factor that comes from Python. One that is written in Python stays alive with its Python
/// object as long as anything holds the pointer.
struct FactorArgument {
  ContinuousFactorPtr pointer;
};

/// The pointers of some of them.
std::vector<ContinuousFactorPtr> to_pointers(const std::vector<FactorArgument>& factors);

/// The pointer to a Python object that is a continuous factor; null where it is none.
ContinuousFactorPtr factor_pointer(py::handle object);

/// A class of settings: made of keywords, one for each of its fields.
template <class T>
class SettingsClass : public py::class_<T> {
 public:
  SettingsClass(py::module_& m, const char* name, const char* doc) : py::class_<T>(m, name, doc) {
    this->def(py::init([](const py::kwargs& fields) {
      py::object made = py::cast(T{});
      for (const auto& [key, value] : fields) {
        if (!py::hasattr(made, key)) {
          throw py::type_error(py::str(py::type::of(made).attr("__name__")).cast<std::string>() +
                               " has no field '" + py::str(key).cast<std::string>() + "'");
        }
        py::setattr(made, key, value);
      }
      return made.template cast<T>();
    }));
  }

  template <class Member>
  SettingsClass& field(const char* name, Member member, const char* doc) {
    this->def_readwrite(name, member, doc);
    return *this;
  }
};

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
