// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <pybind11/pybind11.h>

namespace hybrid::python {

/// Arguments of type To may be given as a Python object of type From: To's constructor in Python
/// converts it. As pybind11's implicitly_convertible(), but what the constructor raises reaches the
/// caller, who reads "a key is a letter and a number; got 'X'" and not a list of all overloads.
template <class From, class To>
void convertible_or_error() {
  const auto convert = [](PyObject* object, PyTypeObject* type) -> PyObject* {
    if (!pybind11::detail::make_caster<From>().load(object, false)) return nullptr;
    PyObject* const made =
        PyObject_CallFunctionObjArgs(reinterpret_cast<PyObject*>(type), object, nullptr);
    if (made == nullptr) throw pybind11::error_already_set();
    return made;
  };
  pybind11::detail::get_type_info(typeid(To), true)->implicit_conversions.emplace_back(convert);
}

}  // namespace hybrid::python
