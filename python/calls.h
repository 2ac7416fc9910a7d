// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <map>
#include <tuple>
#include <type_traits>
#include <utility>

#include "libhybrid/smoother/incremental.h"
#include "python/bindings.h"

namespace hybrid::python {

// Calls that take long release the lock of the interpreter (GIL), so that other Python threads
// run. Whatever these do meanwhile with the arguments must not matter: data is copied first, and
// of an object that changes itself, such as a smoother, one call at a time may change it.

/// A function of data, as a graph and values, that runs on copies of its arguments and without the
/// lock: it sees them as they were when it was called.
template <class Function, class... Arguments>
auto call_on_copies(const Function& function, const Arguments&... arguments) {
  const std::tuple<std::decay_t<Arguments>...> copies(arguments...);
  const py::gil_scoped_release unlocked;
  return std::apply(function, copies);
}

template <class Result, class... Arguments>
auto on_copies(Result (*function)(Arguments...)) {
  return [function](const std::decay_t<Arguments>&... arguments) {
    return call_on_copies(function, arguments...);
  };
}

/// The smoothers that calls without the lock use now, known by their addresses. The lock is held
/// where one begins or ends.
class SmootherInUse {
 public:
  enum class Kind { kRead, kChange };

  /// Throws Error if another call changes the smoother, or if this one would change what another
  /// reads.
  SmootherInUse(const IncrementalSmoother& smoother, Kind kind);
  ~SmootherInUse();
  SmootherInUse(const SmootherInUse&) = delete;
  SmootherInUse& operator=(const SmootherInUse&) = delete;

  static bool is_changing(const IncrementalSmoother& smoother);

 private:
  const IncrementalSmoother* smoother_;
  Kind kind_;
};

inline const IncrementalSmoother& smoother_of(const IncrementalSmoother& smoother) {
  return smoother;
}

template <class Owner>
const IncrementalSmoother& smoother_of(const Owner& owner) {
  return owner.smoother();
}

/// A method of a smoother, or of what owns one, without the lock and on copies of its arguments.
template <class Owner, class Result, class... Arguments>
auto changing(Result (Owner::*method)(Arguments...)) {
  return [method](Owner& self, const std::decay_t<Arguments>&... arguments) {
    const SmootherInUse use(smoother_of(self), SmootherInUse::Kind::kChange);
    return call_on_copies([&](const auto&... a) { return (self.*method)(a...); }, arguments...);
  };
}

/// The same of a function of the owner.
template <class Owner, class Result, class... Arguments>
auto changing(Result (*function)(Owner&, Arguments...)) {
  return [function](Owner& self, const std::decay_t<Arguments>&... arguments) {
    const SmootherInUse use(smoother_of(self), SmootherInUse::Kind::kChange);
    return call_on_copies([&](const auto&... a) { return function(self, a...); }, arguments...);
  };
}

template <class Owner, class Result, class... Arguments>
auto reading(Result (Owner::*method)(Arguments...) const) {
  return [method](const Owner& self, const std::decay_t<Arguments>&... arguments) {
    const SmootherInUse use(smoother_of(self), SmootherInUse::Kind::kRead);
    return call_on_copies([&](const auto&... a) { return (self.*method)(a...); }, arguments...);
  };
}

/// The same of a short function of the owner, which keeps the lock.
template <class Owner, class Result, class... Arguments>
auto looking(Result (*function)(const Owner&, Arguments...)) {
  return [function](const Owner& self, const std::decay_t<Arguments>&... arguments) {
    const SmootherInUse use(smoother_of(self), SmootherInUse::Kind::kRead);
    return function(self, arguments...);
  };
}

}  // namespace hybrid::python
