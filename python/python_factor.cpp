// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "libhybrid/core/loss.h"
#include "libhybrid/core/noise.h"
#include "python/bindings.h"

namespace hybrid::python {
namespace {

constexpr const char* kFactorDoc =
    "A user-defined factor: derive, call super().__init__, and implement `residual`.\n\n"
    "    class Wall(hybrid.Factor):\n"
    "        def __init__(self, pose, distance):\n"
    "            super().__init__([pose], [hybrid.SE2], hybrid.Noise.isotropic(1, 0.1))\n"
    "            self.distance = distance\n"
    "        def residual(self, pose):\n"
    "            return [5.0 - pose.x - self.distance]\n\n"
    "`residual(*values)` returns the residual, as many numbers as the noise has, in the units of "
    "the measurement, not whitened. The optional `jacobians(*values)` returns for each variable "
    "the derivative (rows, dim) with respect to its tangent (see retract of the groups); without "
    "it, central differences are used. Both must depend on their arguments only. Their exceptions "
    "reach the caller of the solver.";

/// A factor whose residual is a method of a Python class.
class PythonFactor : public ContinuousFactor {
 public:
  PythonFactor(const std::vector<Key>& keys, const std::vector<VariableType>& types,
               const Noise& noise, Loss loss)
      : ContinuousFactor(keys, types, noise.dim()), noise_(noise), loss_(loss) {}

  double cost(const double* const* x) const override {
    const py::gil_scoped_acquire lock;
    const Eigen::VectorXd r = noise_.sqrt_information() * residual(arguments(x));
    return 0.5 * loss_.value(r.squaredNorm());
  }

  double linearize(const double* const* x, double* r, double* J) const override {
    const py::gil_scoped_acquire lock;
    const py::tuple values = arguments(x);
    Eigen::Map<Eigen::VectorXd> out(r, rows());
    Eigen::Map<Eigen::MatrixXd> jacobian(J, rows(), cols());
    out = noise_.sqrt_information() * residual(values);
    const py::function given = override_of("jacobians");
    const Eigen::MatrixXd J_own =
        given ? given_jacobian(given, values) : numeric_jacobian(x, values);
    if (given) check_jacobian(J_own, x, values);
    jacobian = noise_.sqrt_information() * J_own;
    const double s = out.squaredNorm();
    const double root = std::sqrt(loss_.weight(s));
    out *= root;
    jacobian *= root;
    return 0.5 * loss_.value(s);
  }

  double log_normalizer() const override { return noise_.log_normalizer(); }

  std::string name() const override {
    const py::gil_scoped_acquire lock;
    return py::str(py::type::of(py::cast(this)).attr("__name__"));
  }

  using ContinuousFactor::cost;

 private:
  py::function override_of(const char* method) const { return py::get_override(this, method); }

  py::tuple arguments(const double* const* x) const {
    py::tuple values(keys().size());
    for (std::size_t i = 0; i < keys().size(); ++i) values[i] = value_of(types()[i], x[i]);
    return values;
  }

  Eigen::VectorXd residual(const py::tuple& values) const {
    const py::function method = override_of("residual");
    if (!method) throw Error(describe(name(), keys()) + ": its class has no method 'residual'");
    const py::object result = method(*values);
    return matrix(result, rows(), 1, "residual");
  }

  /// The result of a method as numbers of this shape. Throws Error for anything else.
  Eigen::MatrixXd matrix(const py::object& result, int m, int n, const char* method) const {
    const auto array = py::array_t<double, py::array::forcecast>::ensure(result);
    if (!array) {
      PyErr_Clear();
      throw Error(describe(name(), keys()) + ": " + method + " returned no array of numbers");
    }
    const bool vector = n == 1 && array.ndim() == 1 && array.shape(0) == m;
    if (!vector && !(array.ndim() == 2 && array.shape(0) == m && array.shape(1) == n)) {
      throw Error(describe(name(), keys()) + ": " + method + " returned an array of shape " +
                  py::str(array.attr("shape")).cast<std::string>() + " instead of (" +
                  std::to_string(m) + (n == 1 ? ",)" : ", " + std::to_string(n) + ")"));
    }
    Eigen::MatrixXd out(m, n);
    for (int i = 0; i < m; ++i) {
      for (int j = 0; j < n; ++j) out(i, j) = vector ? array.at(i) : array.at(i, j);
    }
    return out;
  }

  Eigen::MatrixXd given_jacobian(const py::function& method, const py::tuple& values) const {
    const py::object result = method(*values);
    if (!py::isinstance<py::sequence>(result) || py::len(result) != keys().size()) {
      throw Error(describe(name(), keys()) + ": jacobians must return a sequence of " +
                  std::to_string(keys().size()) + " arrays, one for each variable");
    }
    Eigen::MatrixXd J(rows(), cols());
    int column = 0;
    for (std::size_t i = 0; i < keys().size(); ++i) {
      const int dim = types()[i].dim;
      const py::object block = result[py::int_(i)];
      J.middleCols(column, dim) = matrix(block, rows(), dim, "jacobians");
      column += dim;
    }
    return J;
  }

  /// Warns, once for each class, where its derivatives are not those of its residual: half of the
  /// largest of them apart, as for a wrong sign. Where differences of two steps disagree, the
  /// residual is not smooth, and nothing is told.
  void check_jacobian(const Eigen::MatrixXd& given, const double* const* x,
                      const py::tuple& values) const {
    static std::set<PyTypeObject*> checked;  // of the interpreter, whose lock is held
    const py::object self = py::cast(this);
    if (!checked.insert(Py_TYPE(self.ptr())).second) return;
    Eigen::MatrixXd near, far;
    try {
      near = numeric_jacobian(x, values);
      far = numeric_jacobian(x, values, 10);
    } catch (const std::exception&) {
      return;  // beside these values it has none
    }
    const double most = std::max(near.cwiseAbs().maxCoeff(), given.cwiseAbs().maxCoeff());
    if (!((near - far).cwiseAbs().maxCoeff() < 0.01 * most)) return;
    Eigen::Index row = 0, column = 0;
    if (!((given - near).cwiseAbs().maxCoeff(&row, &column) > 0.5 * most)) return;
    const std::string text = describe(name(), keys()) + ": jacobians has " +
                             std::to_string(given(row, column)) + " in row " + std::to_string(row) +
                             ", column " + std::to_string(column) +
                             ", where differences of residual give " +
                             std::to_string(near(row, column)) + "; a wrong sign or unit?";
    if (PyErr_WarnEx(PyExc_RuntimeWarning, text.c_str(), 1) < 0) throw py::error_already_set();
  }

  /// Central differences. The step balances rounding and truncation for functions of unit scale:
  /// the cube root of the machine precision, times the magnitude of a vector's entry; or `wider`.
  Eigen::MatrixXd numeric_jacobian(const double* const* x, py::tuple values,
                                   double wider = 1) const {
    const double step = wider * std::cbrt(std::numeric_limits<double>::epsilon());
    Eigen::MatrixXd J(rows(), cols());
    int column = 0;
    for (std::size_t i = 0; i < keys().size(); ++i) {
      const VariableType type = types()[i];
      std::vector<double> moved(type.size);
      for (int k = 0; k < type.dim; ++k, ++column) {
        const bool vector = type.kind == VariableKind::kVector;
        const double h = step * (vector ? std::max(1.0, std::abs(x[i][k])) : 1.0);
        Eigen::VectorXd delta = Eigen::VectorXd::Zero(type.dim);
        const auto at = [&](double d) {
          delta[k] = d;
          retract(type, x[i], delta.data(), moved.data());
          py::tuple there = py::tuple(values.size());
          for (std::size_t j = 0; j < values.size(); ++j) there[j] = values[j];
          there[i] = value_of(type, moved.data());
          return residual(there);
        };
        J.col(column) = (at(h) - at(-h)) / (2.0 * h);
      }
    }
    return J;
  }

  Noise noise_;
  Loss loss_;
};

/// Keeps the Python object of a factor alive. If the interpreter has ended before the last pointer
/// is released, there is nothing to do.
struct KeepPython {
  PyObject* object;
  void operator()(const ContinuousFactor*) const {
    if (!Py_IsInitialized()) return;
    const py::gil_scoped_acquire lock;
    Py_DECREF(object);
  }
};

}  // namespace

ContinuousFactorPtr factor_pointer(py::handle object) {
  if (!py::isinstance<ContinuousFactor>(object)) return nullptr;
  auto pointer = object.cast<std::shared_ptr<ContinuousFactor>>();
  if (dynamic_cast<const PythonFactor*>(pointer.get()) == nullptr) return pointer;
  return {pointer.get(), KeepPython{object.inc_ref().ptr()}};
}

PyObject* python_object(const ContinuousFactorPtr& factor) {
  const auto* kept = std::get_deleter<KeepPython>(factor);
  return kept != nullptr ? kept->object : nullptr;
}

std::vector<ContinuousFactorPtr> to_pointers(const std::vector<FactorArgument>& factors) {
  std::vector<ContinuousFactorPtr> pointers;
  pointers.reserve(factors.size());
  for (const FactorArgument& factor : factors) pointers.push_back(factor.pointer);
  return pointers;
}

void bind_python_factor(py::module_& m) {
  py::class_<PythonFactor, ContinuousFactor, std::shared_ptr<PythonFactor>>(m, "Factor", kFactorDoc)
      .def(
          py::init([](const std::vector<Key>& keys, const std::vector<py::object>& types,
                      const Noise& noise, const Loss& loss) {
            if (keys.empty() || keys.size() != types.size()) {
              throw Error("a factor has at least one variable, and one type for each, got " +
                          std::to_string(keys.size()) + " keys and " +
                          std::to_string(types.size()) + " types");
            }
            std::vector<VariableType> variables;
            for (const py::object& type : types) variables.push_back(type_of(type));
            return std::make_shared<PythonFactor>(keys, variables, noise, loss);
          }),
          "keys"_a, "types"_a, "noise"_a, "loss"_a = Loss::none(),
          "Types of the variables: SO2, SE2, SO3, SE3 or the length of a vector. The noise is that "
          "of the residual.");
}

}  // namespace hybrid::python
