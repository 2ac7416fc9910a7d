// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/hybrid/graph.h"
#include "python/bindings.h"

namespace hybrid::python {

// A factor written in Python may refer to the graph that holds it. The garbage collector frees
// such a circle if the graph tells which Python objects it holds. It must tell of each reference
// once, so only factors are told of that nobody else holds: two graphs that share a factor and to
// which it refers are not freed.

/// Calls `visit` for the Python objects that factors hold; returns what it returns unless zero.
int visit_factor(const ContinuousFactorPtr& factor, visitproc visit, void* argument);
int visit_factor(const HybridFactorPtr& factor, visitproc visit, void* argument);

template <class T>
int visit_factors(const std::vector<T>& factors, visitproc visit, void* argument) {
  for (const T& factor : factors) {
    if (const int stop = visit_factor(factor, visit, argument)) return stop;
  }
  return 0;
}

int visit_factors(const HybridGraph& graph, visitproc visit, void* argument);

/// The C++ object of a Python object of a class bound for T; null if that does not own one.
template <class T>
T* owned(PyObject* self) {
  const auto place = reinterpret_cast<py::detail::instance*>(self)->get_value_and_holder();
  return place.holder_constructed() ? place.value_ptr<T>() : nullptr;
}

/// Lets the garbage collector look into objects of type T. `Access` has two functions: `visit` of a
/// const T&, and `clear`, which releases the factors.
template <class T, class Access>
py::custom_type_setup collected() {
  return py::custom_type_setup([](PyHeapTypeObject* heap_type) {
    PyTypeObject& type = heap_type->ht_type;
    type.tp_flags |= Py_TPFLAGS_HAVE_GC;
    type.tp_traverse = [](PyObject* self, visitproc visit, void* argument) -> int {
      if (const int stop = visit(reinterpret_cast<PyObject*>(Py_TYPE(self)), argument)) return stop;
      const T* object = owned<T>(self);
      return object != nullptr ? Access::visit(*object, visit, argument) : 0;
    };
    type.tp_clear = [](PyObject* self) -> int {
      if (T* object = owned<T>(self)) Access::clear(*object);
      return 0;
    };
    type.tp_dealloc = [](PyObject* self) {
      PyObject_GC_UnTrack(self);
      py::detail::pybind11_object_dealloc(self);
    };
  });
}

}  // namespace hybrid::python
