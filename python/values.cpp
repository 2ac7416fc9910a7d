// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/core/values.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "python/bindings.h"
#include "python/conversions.h"

namespace hybrid::python {
namespace {

using Rows = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// The name of a number of a value, for messages.
std::string name_of(VariableType type, int i) {
  const auto among = [&](std::initializer_list<const char*> names) { return names.begin()[i]; };
  switch (type.kind) {
    case VariableKind::kSO2:
      return "angle";
    case VariableKind::kSE2:
      return among({"x", "y", "angle", "angle"});
    case VariableKind::kSO3:
      return among({"qx", "qy", "qz", "qw"});
    case VariableKind::kSE3:
      return among({"x", "y", "z", "qx", "qy", "qz", "qw"});
    default:
      return "number " + std::to_string(i + 1) + " of " + std::to_string(type.size);
  }
}

/// Throws Error that names variable and number if one is not finite.
void check_finite(const Values& values, Key key, VariableType type, const double* x) {
  for (int i = 0; i < type.size; ++i) {
    if (std::isfinite(x[i])) continue;
    throw Error((values.contains(key) ? "value of " : "initial value of ") + to_string(key) +
                " is not finite: its " + name_of(type, i) + " is " +
                (std::isnan(x[i]) ? "nan" : "infinite"));
  }
}

template <class T>
void check_finite(const Values& values, Key key, const T& value) {
  double x[Variable<T>::kSize];
  Variable<T>::store(value, x);
  check_finite(values, key, Variable<T>::type(), x);
}

void check_finite(const Values& values, Key key, const Eigen::VectorXd& value) {
  check_finite(values, key, vector_type(static_cast<int>(value.size())), value.data());
}

template <class T>
void put(Values& values, Key key, const T& value) {
  check_finite(values, key, value);
  if (values.contains(key)) {
    values.update(key, value);
  } else {
    values.insert(key, value);
  }
}

void put_vector(Values& values, Key key, const Eigen::VectorXd& value) {
  check_finite(values, key, value);
  if (!values.contains(key)) {
    values.insert(key, value);
    return;
  }
  const VariableType type = vector_type(static_cast<int>(value.size()));
  if (values.type(key) != type) {
    throw Error("variable " + to_string(key) + " is of type " + to_string(values.type(key)) +
                ", not " + to_string(type));
  }
  std::memcpy(values.data(values.slot(key)), value.data(), sizeof(double) * type.size);
}

/// Binds `insert` and `[] =` for one type of value, a class or a vector.
template <class T>
void bind_value(py::class_<Values>& c) {
  c.def(
      "insert",
      [](Values& values, Key key, const T& value) {
        check_finite(values, key, value);
        values.insert(key, value);
      },
      "key"_a, "value"_a, "Adds a variable; raises Error if the key exists.");
  c.def("__setitem__", &put<T>, "key"_a, "value"_a);
}

std::vector<Key> keys_of(const Values& values, const std::string& letters) {
  std::vector<Key> keys;
  for (const Key key : values.keys()) {
    if (letters.empty() || letters.find(key.letter()) != std::string::npos) keys.push_back(key);
  }
  return keys;
}

Rows stack(const Values& values, const std::vector<Key>& keys) {
  if (keys.empty()) return Rows(std::vector<py::ssize_t>{0, 0});
  const VariableType type = values.type(keys.front());
  Rows rows(std::vector<py::ssize_t>{static_cast<py::ssize_t>(keys.size()), type.size});
  double* row = rows.mutable_data();
  for (const Key key : keys) {
    if (values.type(key) != type) {
      throw Error("variable " + to_string(key) + " is of type " + to_string(values.type(key)) +
                  ", and " + to_string(keys.front()) + " of " + to_string(type));
    }
    row = std::copy_n(values.data(key), type.size, row);
  }
  return rows;
}

void insert_stack(Values& values, const std::vector<Key>& keys, const py::object& type_argument,
                  const Rows& rows) {
  const VariableType type = type_of(type_argument);
  if (rows.ndim() != 2 || rows.shape(0) != static_cast<py::ssize_t>(keys.size()) ||
      rows.shape(1) != type.size) {
    throw Error(std::to_string(keys.size()) + " variables of type " + to_string(type) +
                " take an array of " + std::to_string(keys.size()) + " x " +
                std::to_string(type.size) + " numbers");
  }
  for (std::size_t i = 0; i < keys.size(); ++i) {
    values.insert(keys[i], type, rows.data(static_cast<py::ssize_t>(i), 0));
  }
}

Values from_dict(const py::dict& items) {
  Values values;
  const py::object self = py::cast(&values, py::return_value_policy::reference);
  for (const auto& [key, value] : items) self.attr("__setitem__")(key, value);
  return values;
}

/// Key and value of each variable, in the order of insertion.
std::vector<std::pair<Key, py::object>> items_of(const Values& values, const std::string& letters) {
  std::vector<std::pair<Key, py::object>> items;
  for (const Key key : keys_of(values, letters)) {
    items.emplace_back(key, value_of(values.type(key), values.data(key)));
  }
  return items;
}

/// Whether two have the same variables, in any order, with the same numbers.
bool equal(const Values& a, const Values& b) {
  const std::vector<Key> keys = a.keys();
  return a.size() == b.size() && std::all_of(keys.begin(), keys.end(), [&](Key key) {
           return b.contains(key) && a.type(key) == b.type(key) &&
                  std::equal(a.data(key), a.data(key) + a.type(key).size, b.data(key));
         });
}

/// Variables of many types by keys, types and storage, for pickle.
py::tuple state_of(const Values& values) {
  py::list state;
  for (const auto& [key, value] : items_of(values, "")) {
    state.append(py::make_tuple(to_string(key), value));
  }
  return py::make_tuple(state);
}

Values from_state(const py::tuple& state) {
  return from_dict(py::module_::import("builtins").attr("dict")(*state));
}

/// What a dict of Python has beside.
void bind_mapping(py::class_<Values>& c) {
  c.def(
       "values",
       [](const Values& values) {
         py::list all;
         for (const auto& [key, value] : items_of(values, "")) all.append(value);
         return all;
       },
       "The values, copies, in the order of insertion.")
      .def(
          "get",
          [](const Values& values, Key key, const py::object& otherwise) {
            const int slot = values.find(key);
            return slot < 0 ? otherwise : value_of(values.type(slot), values.data(slot));
          },
          "key"_a, "default"_a = py::none(), "The value, a copy, or the default.")
      .def(
          "update",
          [](Values& values, const Values& other) {
            const py::object self = py::cast(&values, py::return_value_policy::reference);
            for (const auto& [key, value] : items_of(other, "")) {
              self.attr("__setitem__")(key, value);
            }
          },
          "other"_a, "Adds the variables of another, or replaces their values.")
      .def("__eq__", &equal, py::is_operator(), py::arg("other").noconvert(),
           "Whether variables and numbers are the same, in any order.");
}

}  // namespace

py::object value_of(VariableType type, const double* x) {
  switch (type.kind) {
    case VariableKind::kSO2:
      return py::cast(SO2::load(x));
    case VariableKind::kSE2:
      return py::cast(SE2::load(x));
    case VariableKind::kSO3:
      return py::cast(SO3::load(x));
    case VariableKind::kSE3:
      return py::cast(SE3::load(x));
    default:
      return py::array_t<double>(type.size, x);
  }
}

VariableType type_of(const py::handle& type) {
  if (type.is(py::type::of<SO2>())) return Variable<SO2>::type();
  if (type.is(py::type::of<SE2>())) return Variable<SE2>::type();
  if (type.is(py::type::of<SO3>())) return Variable<SO3>::type();
  if (type.is(py::type::of<SE3>())) return Variable<SE3>::type();
  if (py::isinstance<py::int_>(type) && type.cast<long>() > 0 && type.cast<long>() < 100000) {
    return vector_type(type.cast<int>());
  }
  throw Error("a type of variable is SO2, SE2, SO3, SE3 or the length of a vector, not " +
              py::repr(type).cast<std::string>());
}

py::object to_python(VariableType type) {
  switch (type.kind) {
    case VariableKind::kSO2:
      return py::type::of<SO2>();
    case VariableKind::kSE2:
      return py::type::of<SE2>();
    case VariableKind::kSO3:
      return py::type::of<SO3>();
    case VariableKind::kSE3:
      return py::type::of<SE3>();
    default:
      return py::int_(type.size);
  }
}

void bind_values(py::module_& m) {
  py::class_<Values> c(m, "Values",
                       "Values of continuous variables by key: SO2, SE2, SO3, SE3 or arrays "
                       "(n,) of float64.");
  c.def(py::init<>());
  bind_value<SO2>(c);
  bind_value<SE2>(c);
  bind_value<SO3>(c);
  bind_value<SE3>(c);
  c.def(
      "insert",
      [](Values& values, Key key, const Eigen::VectorXd& value) {
        check_finite(values, key, value);
        values.insert(key, value);
      },
      "key"_a, "value"_a, "Adds a variable; raises Error if the key exists.");
  c.def("__setitem__", &put_vector, "key"_a, "value"_a);
  convertible_or_error<py::dict, Values>();
  c.def(py::init(&from_dict), "values"_a, "From a dict of key: value.")
      .def(
          "__getitem__",
          [](const Values& values, Key key) {
            const int slot = values.slot(key);
            return value_of(values.type(slot), values.data(slot));
          },
          "key"_a, "The value, a copy.")
      .def(
          "__delitem__",
          [](Values& values, Key key) {
            values.slot(key);
            values.erase(key);
          },
          "key"_a)
      .def("__contains__", &Values::contains, "key"_a)
      .def("__len__", &Values::size)
      .def("__copy__", [](const Values& values) { return Values(values); })
      .def(
          "__deepcopy__", [](const Values& values, const py::dict&) { return Values(values); },
          "memo"_a)
      .def(py::pickle(&state_of, &from_state));
  bind_mapping(c);
  c.def(
       "__iter__", [](const Values& values) { return py::iter(py::cast(keys_of(values, ""))); },
       "The keys, in the order of insertion.")
      .def("items", &items_of, "letters"_a = "",
           "Pairs of key and value; only those with the given letters, if any.")
      .def("keys", &keys_of, "letters"_a = "",
           "Keys in the order of insertion; only those with the given letters, if any.")
      .def("stack", &stack, "keys"_a,
           "The storage of variables of one type as rows (n, size), see `storage` of the groups.")
      .def("insert_stack", &insert_stack, "keys"_a, "type"_a, "rows"_a,
           "Adds variables of one type (SO2, SE2, SO3, SE3 or the length of vectors) from their "
           "storage (n, size).")
      .def("__repr__", [](const Values& values) {
        return "<Values of " + std::to_string(values.size()) + " variables>";
      });
}

}  // namespace hybrid::python
