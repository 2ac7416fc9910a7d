// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <pybind11/operators.h>

#include <algorithm>
#include <charconv>
#include <map>

#include "libhybrid/core/assignment.h"
#include "libhybrid/core/chi_square.h"
#include "libhybrid/core/key.h"
#include "libhybrid/core/loss.h"
#include "libhybrid/core/noise.h"
#include "python/bindings.h"
#include "python/conversions.h"

namespace hybrid::python {
namespace {

/// Parses "x3" into Key{'x', 3}. Throws Error for any other text.
Key parse_key(const std::string& text) {
  std::uint64_t index = 0;
  const char* const end = text.data() + text.size();
  const auto [rest, code] = std::from_chars(text.data() + (text.empty() ? 0 : 1), end, index);
  const bool is_number = text.size() >= 2 && code != std::errc::invalid_argument && rest == end;
  if (!is_number) throw Error("a key is a letter and a number, such as 'x3'; got '" + text + "'");
  constexpr std::uint64_t kLimit = std::uint64_t{1} << 56;
  if (code != std::errc() || index >= kLimit) {
    throw Error("the number of a key is below 2^56 = " + std::to_string(kLimit) + "; got '" + text +
                "'");
  }
  return {text[0], index};
}

/// Refuses a number where a key is expected, by a message instead of a list of overloads.
PyObject* refuse_number(PyObject* object, PyTypeObject*) {
  if (PyIndex_Check(object) == 0) return nullptr;
  throw Error("a key is a letter and a number, such as 'x3'; got " +
              py::str(py::handle(object)).cast<std::string>());
}

/// Whether another object is the same key, or its text.
bool is_key(Key key, const py::object& other) {
  if (py::isinstance<Key>(other)) return key == other.cast<Key>();
  return py::isinstance<py::str>(other) && to_string(key) == other.cast<std::string>();
}

void bind_keys(py::module_& m) {
  py::class_<Key>(m, "Key",
                  "Name of a variable: a letter and a number below 2^56. Functions that take a key "
                  "also accept its text, such as 'x3'.")
      .def(py::init([](const std::string& letter, std::uint64_t index) {
             if (letter.size() == 1) return parse_key(letter + std::to_string(index));
             throw Error("a key is a letter and a number, such as Key('x', 3); its letter is '" +
                         letter + "'");
           }),
           "letter"_a, "index"_a)
      .def(py::init(&parse_key), "text"_a, "From a text such as 'x3'.")
      .def_property_readonly("letter", &Key::letter)
      .def_property_readonly("index", &Key::index)
      .def("__eq__", &is_key, "other"_a)
      .def(py::self < py::self)
      .def("__hash__", [](Key key) { return std::hash<Key>()(key); })
      .def("__str__", [](Key key) { return to_string(key); })
      .def("__repr__", [](Key key) { return "Key('" + to_string(key) + "')"; })
      .def(py::pickle([](Key key) { return to_string(key); }, &parse_key));
  convertible_or_error<py::str, Key>();
  py::detail::get_type_info(typeid(Key), true)->implicit_conversions.emplace_back(&refuse_number);
  py::class_<DiscreteKey>(m, "DiscreteKey",
                          "A discrete variable: its key and the number of values it can take.")
      .def(py::init([](Key key, int cardinality) {
             if (cardinality < 1) {
               throw Error("discrete variable " + to_string(key) +
                           " needs at least one value, got " + std::to_string(cardinality));
             }
             return DiscreteKey{key, cardinality};
           }),
           "key"_a, "cardinality"_a)
      .def_readonly("key", &DiscreteKey::key)
      .def_readonly("cardinality", &DiscreteKey::cardinality)
      .def(py::self == py::self)
      .def("__hash__", [](const DiscreteKey& key) { return std::hash<Key>()(key.key); })
      .def(py::pickle(
          [](const DiscreteKey& key) { return py::make_tuple(key.key, key.cardinality); },
          [](const py::tuple& state) {
            return DiscreteKey{state[0].cast<Key>(), state[1].cast<int>()};
          }))
      .def("__repr__", [](const DiscreteKey& key) {
        return "DiscreteKey('" + to_string(key.key) + "', " + std::to_string(key.cardinality) + ")";
      });
}

/// The noise whose square-root information is R, up to rounding.
Noise noise_of_root(const Eigen::MatrixXd& R) {
  if (R.isDiagonal(0.0)) return Noise::diagonal(R.diagonal().cwiseInverse());
  return Noise::information(R.transpose() * R);
}

void bind_noise(py::module_& m) {
  py::class_<Noise>(m, "Noise",
                    "Zero-mean Gaussian noise of a measurement of n numbers, in their units.")
      .def_static("isotropic", &Noise::isotropic, "dim"_a, "sigma"_a,
                  "The same standard deviation for all entries.")
      .def_static("diagonal", &Noise::diagonal, "sigmas"_a, "From standard deviations (n,).")
      .def_static("from_covariance", py::overload_cast<const Eigen::MatrixXd&>(&Noise::covariance),
                  "covariance"_a, "From a symmetric positive definite covariance (n, n).")
      .def_static("from_information",
                  py::overload_cast<const Eigen::MatrixXd&>(&Noise::information), "information"_a,
                  "From the inverse of a covariance (n, n).")
      .def_static("unit", &Noise::unit, "dim"_a, "Standard deviations of 1.")
      .def_property_readonly("dim", &Noise::dim)
      .def_property_readonly(
          "sqrt_information", [](const Noise& noise) { return noise.sqrt_information(); },
          "Upper triangular R (n, n), where R'R is the information.")
      .def_property_readonly(
          "covariance", [](const Noise& noise) { return Eigen::MatrixXd(noise.covariance()); },
          "(n, n).")
      .def_property_readonly("log_normalizer", &Noise::log_normalizer,
                             "-log of the density at zero.")
      .def("inflated", &Noise::inflated, "factor"_a, "The covariance multiplied by a number.")
      .def(py::pickle([](const Noise& noise) { return noise.sqrt_information(); }, &noise_of_root))
      .def("__repr__", [](const Noise& noise) {
        return "<Noise of dimension " + std::to_string(noise.dim()) + ">";
      });
}

void bind_loss(py::module_& m) {
  py::class_<Loss>(m, "Loss",
                   "A robust loss rho(s) of the squared whitened norm s; the cost is rho / 2. "
                   "Parameters are in standard deviations.")
      .def_static("none", &Loss::none)
      .def_static("huber", &Loss::huber, "k"_a = 1.345)
      .def_static("cauchy", &Loss::cauchy, "k"_a = 2.385)
      .def_static("tukey", &Loss::tukey, "k"_a = 4.685)
      .def_static("geman_mcclure", &Loss::geman_mcclure, "k"_a = 1.0)
      .def("value", &Loss::value, "s"_a, "rho(s).")
      .def("weight", &Loss::weight, "s"_a, "rho'(s), in [0, 1].")
      .def(py::pickle(
          [](const Loss& loss) {
            return py::make_tuple(static_cast<int>(loss.kind), loss.parameter);
          },
          [](const py::tuple& state) {
            return Loss{static_cast<Loss::Kind>(state[0].cast<int>()), state[1].cast<double>()};
          }))
      .def("__repr__", [](const Loss& loss) {
        const char* const names[] = {"none", "huber", "cauchy", "tukey", "geman_mcclure"};
        const bool none = loss.kind == Loss::Kind::kNone;
        return "Loss." + std::string(names[static_cast<int>(loss.kind)]) + "(" +
               (none ? "" : py::repr(py::float_(loss.parameter)).cast<std::string>()) + ")";
      });
}

Assignment to_assignment(const py::dict& values) {
  Assignment assignment;
  for (const auto& [name, value] : values) {
    const Key key = name.cast<Key>();
    if (PyIndex_Check(value.ptr()) == 0 || value.cast<py::int_>() < py::int_(0)) {
      throw Error("the value of discrete variable " + to_string(key) +
                  " is a whole number of at least 0; got " + py::repr(value).cast<std::string>());
    }
    assignment.set(key, value.cast<int>());
  }
  return assignment;
}

void bind_assignment(py::module_& m) {
  py::class_<Assignment>(m, "Assignment", "The values of discrete variables, by key.")
      .def(py::init<>())
      .def(py::init(&to_assignment), "values"_a, "From a dict of key: value.")
      .def("__getitem__", &Assignment::at, "key"_a)
      .def("__setitem__", &Assignment::set, "key"_a, "value"_a)
      .def("__delitem__", &Assignment::erase, "key"_a)
      .def("__contains__", &Assignment::contains, "key"_a)
      .def("__len__", &Assignment::size)
      .def(
          "to_dict",
          [](const Assignment& assignment) {
            std::map<Key, int> sorted(assignment.begin(), assignment.end());
            py::dict values;
            for (const auto& [key, value] : sorted) values[py::cast(key)] = value;
            return values;
          },
          "A dict in the order of the keys.")
      .def(py::self == py::self)
      .def("__repr__",
           [](const py::object& self) {
             return "Assignment(" + py::repr(self.attr("to_dict")()).cast<std::string>() + ")";
           })
      .def(
          "__iter__", [](const py::object& self) { return py::iter(self.attr("to_dict")()); },
          "The keys, sorted.")
      .def(
          "items",
          [](const Assignment& assignment) {
            std::vector<std::pair<Key, int>> items(assignment.begin(), assignment.end());
            std::sort(items.begin(), items.end());
            return items;
          },
          "Pairs of key and value, sorted.")
      .def("__copy__", [](const Assignment& assignment) { return Assignment(assignment); })
      .def(
          "__deepcopy__",
          [](const Assignment& assignment, const py::dict&) { return Assignment(assignment); },
          "memo"_a)
      .def(py::pickle([](const py::object& self) { return py::dict(self.attr("to_dict")()); },
                      &to_assignment));
  convertible_or_error<py::dict, Assignment>();
}

}  // namespace

void bind_core(py::module_& m) {
  auto& error = py::register_exception<Error>(m, "Error", PyExc_RuntimeError);
  error.doc() = "Misuse or bad input; the message says what is wrong, where, and what to do.";
  py::register_exception<SettingsError>(m, "SettingsError", error).doc() =
      "Settings that are invalid for any data.";
  bind_keys(m);
  bind_noise(m);
  bind_loss(m);
  bind_assignment(m);
  m.def("chi_square_quantile", &chi_square_quantile, "probability"_a, "degrees"_a,
        "The quantile of the chi-square distribution.");
}

}  // namespace hybrid::python
