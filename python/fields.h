// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cctype>
#include <cstddef>
#include <functional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "libhybrid/core/option.h"
#include "python/bindings.h"

namespace hybrid::python {

/// An object whose fields are set next.
template <class T>
struct Blank {
  static T make() { return T{}; }
};

template <class M>
py::object state_of_field(const M& value) {
  if constexpr (std::is_enum_v<M>) {
    return py::int_(static_cast<int>(value));
  } else if constexpr (std::is_base_of_v<py::object, M>) {
    return value;
  } else {
    return py::cast(value, py::return_value_policy::copy);
  }
}

template <class M>
void set_field(py::handle state, M& value) {
  if constexpr (std::is_enum_v<M>) {
    value = static_cast<M>(state.cast<int>());
  } else if constexpr (std::is_same_v<M, std::vector<ContinuousFactorPtr>>) {
    value = to_pointers(state.cast<std::vector<FactorArgument>>());
  } else {
    value = state.cast<M>();
  }
}

/// A class that pickles and copies take by its fields: those that are bound, and those named by
/// `kept`. Fields that a pickle lacks have their defaults.
template <class T, class... More>
class FieldsClass : public py::class_<T, More...> {
 public:
  using Base = py::class_<T, More...>;

  template <class... Extra>
  FieldsClass(py::module_& m, const char* name, const char* doc, const Extra&... extra)
      : Base(m, name, doc, extra...) {
    fields().clear();
    (inherit<More>(), ...);
    Base::def(py::pickle(&state_of, &from_state));
    Base::def("__copy__", [](const T& thing) { return T(thing); });
  }

  /// A field that is kept and not shown.
  template <class M, class Owner>
  FieldsClass& kept(const char* name, M Owner::*member) {
    fields().push_back({name, [member](const T& thing) { return state_of_field(thing.*member); },
                        [member](T& thing, py::handle state) { set_field(state, thing.*member); }});
    return *this;
  }
  template <class Get, class Set>
  FieldsClass& kept(const char* name, const Get& get, const Set& set) {
    using Value = std::decay_t<std::invoke_result_t<Get, const T&>>;
    fields().push_back({name, [get](const T& thing) { return state_of_field<Value>(get(thing)); },
                        [set](T& thing, py::handle state) { set(thing, state.cast<Value>()); }});
    return *this;
  }

  template <class M, class Owner>
  FieldsClass& def_readonly(const char* name, M Owner::*member, const char* doc = "") {
    Base::def_readonly(name, member, doc);
    return kept(name, member);
  }
  template <class M, class Owner>
  FieldsClass& def_readwrite(const char* name, M Owner::*member, const char* doc = "") {
    Base::def_readwrite(name, member, doc);
    return kept(name, member);
  }
  template <class... Arguments>
  FieldsClass& def_property_readonly(const Arguments&... arguments) {
    Base::def_property_readonly(arguments...);
    return *this;
  }
  template <class Get, class Set>
  FieldsClass& def_property(const char* name, const Get& get, const Set& set, const char* doc) {
    Base::def_property(name, get, set, doc);
    return kept(name, get, set);
  }
  template <class... Arguments>
  FieldsClass& def(Arguments&&... arguments) {
    Base::def(std::forward<Arguments>(arguments)...);
    return *this;
  }

 private:
  struct Field {
    std::string name;
    std::function<py::object(const T&)> get;
    std::function<void(T&, py::handle)> set;
  };
  template <class, class...>
  friend class FieldsClass;

  static std::vector<Field>& fields() {
    static std::vector<Field> all;
    return all;
  }

  template <class Parent>
  void inherit() {
    if constexpr (std::is_base_of_v<Parent, T>) {
      for (const auto& field : FieldsClass<Parent>::fields()) {
        fields().push_back({field.name, field.get, field.set});
      }
    }
  }

  static py::dict state_of(const T& thing) {
    py::dict state;
    for (const Field& field : fields()) state[py::str(field.name)] = field.get(thing);
    return state;
  }
  static T from_state(const py::dict& state) {
    T thing = Blank<T>::make();
    for (const Field& field : fields()) {
      if (state.contains(field.name)) field.set(thing, state[py::str(field.name)]);
    }
    return thing;
  }
};

/// With a capital and a full stop.
inline std::string sentence(std::string text) {
  text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  return text.back() == '.' ? text : text + '.';
}

/// The names in capitals.
template <class Enum, std::size_t n>
void bind_enum(py::module_& m, const char* name, const Named<Enum> (&values)[n]) {
  py::enum_<Enum> bound(m, name);
  for (const Named<Enum>& one : values) {
    std::string capitals = one.name;
    for (char& c : capitals) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    bound.value(capitals.c_str(), one.value);
  }
}

/// A class of settings, constructed from keywords, one for each field.
template <class T>
class SettingsClass : public FieldsClass<T> {
 public:
  SettingsClass(py::module_& m, const char* name, const char* doc) : FieldsClass<T>(m, name, doc) {
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
    this->def_readwrite(name, member, sentence(doc).c_str());
    return *this;
  }

  /// All that T::describe tells, see libhybrid/core/option.h.
  SettingsClass& described() {
    T::describe(*this);
    return *this;
  }
  template <class Member>
  void option(const char* name, Member member, const char* meaning) {
    field(name, member, meaning);
  }
  template <class Member>
  void option(const char* name, Member member, const Interval&, const char* meaning,
              const char* = nullptr) {
    field(name, member, meaning);
  }
  template <class Member, class Choices>
  void choice(const char* name, Member member, const char* meaning, const Choices&) {
    field(name, member, meaning);
  }
};

}  // namespace hybrid::python
