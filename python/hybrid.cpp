// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/hybrid/graph.h"
#include "python/calls.h"
#include "python/conversions.h"
#include "python/fields.h"
#include "python/garbage.h"

namespace hybrid::python {
namespace {

template <class T>
std::vector<T> all_of(const HandleList<T>& factors) {
  std::vector<T> all;
  factors.for_each([&](Handle, const T& factor) { all.push_back(factor); });
  return all;
}

/// Adds whatever can be iterated over, such as a list of factors.
template <class Target>
py::list add_all(Target& target, const py::iterable& factors) {
  if (py::isinstance<py::str>(factors)) throw py::type_error("factors are wanted, not a text");
  const py::object self = py::cast(&target, py::return_value_policy::reference);
  py::list handles;
  for (const py::handle factor : factors) handles.append(self.attr("add")(factor));
  return handles;
}

py::list factors_of(const HybridGraph& graph) {
  py::list all;
  for (const auto& factor : all_of(graph.continuous())) all.append(factor);
  for (const auto& table : all_of(graph.discrete())) all.append(table);
  for (const auto& factor : all_of(graph.hybrid())) all.append(factor);
  return all;
}

struct GraphAccess {
  static int visit(const HybridGraph& graph, visitproc visit, void* argument) {
    return visit_factors(graph, visit, argument);
  }
  static void clear(HybridGraph& graph) { const HybridGraph gone = std::exchange(graph, {}); }
};

struct DeltaAccess {
  static int visit(const Delta& delta, visitproc visit, void* argument) {
    const int stop = visit_factors(delta.continuous, visit, argument);
    return stop != 0 ? stop : visit_factors(delta.hybrid, visit, argument);
  }
  static void clear(Delta& delta) { const Delta gone = std::exchange(delta, {}); }
};

std::string describe(const HybridGraph& graph) {
  return "<HybridGraph of " + std::to_string(graph.continuous().size()) + " continuous, " +
         std::to_string(graph.discrete().size()) + " discrete and " +
         std::to_string(graph.hybrid().size()) + " hybrid factors>";
}

void bind_handles(py::module_& m) {
  py::enum_<FactorKind>(m, "FactorKind")
      .value("CONTINUOUS", FactorKind::kContinuous)
      .value("DISCRETE", FactorKind::kDiscrete)
      .value("HYBRID", FactorKind::kHybrid);
  FieldsClass<Handle>(m, "Handle",
                      "Identifies a factor in a graph, from its addition to its removal.")
      .kept("index", &Handle::index)
      .kept("generation", &Handle::generation)
      .def_readonly("kind", &Handle::kind)
      .def(
          "__eq__", [](Handle a, Handle b) { return a == b; }, "other"_a)
      .def("__hash__", [](Handle h) {
        return std::hash<std::uint64_t>()((std::uint64_t{h.index} << 32 | h.generation) * 4 +
                                          static_cast<unsigned>(h.kind));
      });
  FieldsClass<AddedHandles>(m, "AddedHandles", "Handles of the factors added by a change.")
      .def_readonly("continuous", &AddedHandles::continuous)
      .def_readonly("discrete", &AddedHandles::discrete)
      .def_readonly("hybrid", &AddedHandles::hybrid)
      .def("all", &AddedHandles::all, "Continuous, discrete, hybrid.")
      .def("__len__", &AddedHandles::size);
}

/// What a list of Python has beside.
void bind_places(py::class_<HybridGraph>& c) {
  c.def(
       "__getitem__",
       [](const HybridGraph& graph, const py::int_& i) {
         return py::object(factors_of(graph).attr("__getitem__")(i));
       },
       "index"_a, "A factor by its place in the order of iteration.")
      .def(
          "__getitem__",
          [](const HybridGraph& graph, const py::slice& places) {
            return py::list(factors_of(graph).attr("__getitem__")(places));
          },
          "places"_a)
      .def(
          "__iadd__",
          [](const py::object& self, const py::object& factors) {
            self.attr("add")(factors);
            return self;
          },
          "factors"_a, "Adds a factor, or several.");
}

void bind_graph(py::module_& m) {
  py::class_<HybridGraph> c(
      m, "HybridGraph",
      "A discrete-continuous factor graph (eq. 2): continuous factors, tables, "
      "hybrid factors.",
      collected<HybridGraph, GraphAccess>());
  bind_places(c);
  c.def(py::init<>())
      .def(py::init([](const py::iterable& factors) {
             HybridGraph graph;
             add_all(graph, factors);
             return graph;
           }),
           "factors"_a, "Of factors, tables and hybrid factors, such as a list or another graph.")
      .def(
          "add",
          [](HybridGraph& graph, const FactorArgument& factor) {
            return graph.add(factor.pointer);
          },
          "factor"_a, "Adds a factor, a table or a hybrid factor.")
      .def(
          "add", [](HybridGraph& graph, const Table& table) { return graph.add(table); },
          "factor"_a)
      .def(
          "add",
          [](HybridGraph& graph, const std::shared_ptr<HybridFactor>& factor) {
            return graph.add(HybridFactorPtr(factor));
          },
          "factor"_a)
      .def("add", &add_all<HybridGraph>, "factors"_a, "Adds several; returns their handles.")
      .def(
          "remove", [](HybridGraph& graph, Handle handle) { graph.remove(handle); }, "handle"_a)
      .def("__contains__", &HybridGraph::contains, "handle"_a)
      .def("__len__", &HybridGraph::size, "Number of factors of all kinds.")
      .def("__copy__", [](const HybridGraph& graph) { return HybridGraph(graph); })
      .def(
          "__deepcopy__",
          [](const HybridGraph& graph, const py::dict&) { return HybridGraph(graph); }, "memo"_a,
          "A copy with the same factors, which never change.")
      .def(
          "__iter__", [](const HybridGraph& graph) { return py::iter(factors_of(graph)); },
          "Continuous factors, tables, hybrid factors.")
      .def("__repr__", &describe)
      .def_property_readonly("continuous",
                             [](const HybridGraph& graph) { return all_of(graph.continuous()); })
      .def_property_readonly("discrete",
                             [](const HybridGraph& graph) { return all_of(graph.discrete()); })
      .def_property_readonly("hybrid",
                             [](const HybridGraph& graph) { return all_of(graph.hybrid()); })
      .def("discrete_keys", &HybridGraph::discrete_keys,
           "All discrete variables, in the order of first appearance.");
}

void bind_delta(py::module_& m) {
  const auto factors = [](const Delta& delta) {
    py::list all;
    for (const auto& factor : delta.continuous) all.append(factor);
    for (const auto& table : delta.discrete) all.append(table);
    for (const auto& factor : delta.hybrid) all.append(factor);
    return all;
  };
  FieldsClass<Delta>(m, "Delta", "One atomic change of a graph, for the smoothers.",
                     collected<Delta, DeltaAccess>())
      .kept("factors", factors, [](Delta& delta, const py::list& all) { add_all(delta, all); })
      .def(py::init<>())
      .def(
          "add",
          [](Delta& delta, const FactorArgument& factor) {
            delta.continuous.push_back(factor.pointer);
          },
          "factor"_a, "A factor, table or hybrid factor to add.")
      .def(
          "add", [](Delta& delta, const Table& table) { delta.discrete.push_back(table); },
          "factor"_a)
      .def(
          "add",
          [](Delta& delta, const std::shared_ptr<HybridFactor>& factor) {
            delta.hybrid.push_back(factor);
          },
          "factor"_a)
      .def(
          "add", [](Delta& delta, const py::iterable& factors) { add_all(delta, factors); },
          "factors"_a, "Adds several.")
      .def_readwrite("values", &Delta::values, "Initial values of new continuous variables.")
      .def_readwrite("assignment", &Delta::assignment,
                     "Initial values of new discrete variables; 0 if not given.")
      .def_readwrite("remove", &Delta::remove, "Handles of factors to remove.")
      .def_readwrite("remove_values", &Delta::remove_values, "Continuous variables to remove.");
}

}  // namespace

void bind_hybrid(py::module_& m) {
  bind_handles(m);
  bind_mixtures(m);
  bind_graph(m);
  py::class_<Estimate>(m, "Estimate", "Values of all variables.")
      .def(py::init([](const Values& values, const Assignment& assignment) {
             return Estimate{values, assignment};
           }),
           "values"_a = Values(), "assignment"_a = Assignment())
      .def("__copy__", [](const Estimate& estimate) { return Estimate(estimate); })
      .def(
          "__deepcopy__",
          [](const Estimate& estimate, const py::dict&) { return Estimate(estimate); }, "memo"_a)
      .def(py::pickle(
          [](const Estimate& estimate) {
            return py::make_tuple(estimate.values, estimate.assignment);
          },
          [](const py::tuple& state) {
            return Estimate{state[0].cast<Values>(), state[1].cast<Assignment>()};
          }))
      .def_readwrite("values", &Estimate::values, "Continuous.")
      .def_readwrite("assignment", &Estimate::assignment, "Discrete.");
  convertible_or_error<Values, Estimate>();
  convertible_or_error<py::dict, Estimate>();
  bind_delta(m);
  m.def("objective", on_copies(&objective), "graph"_a, "values"_a, "assignment"_a = Assignment(),
        "The joint negative log posterior of eq. 6, normalisers included.");
  m.def("cost",
        on_copies(py::overload_cast<const HybridGraph&, const Values&, const Assignment&>(&cost)),
        "graph"_a, "values"_a, "assignment"_a = Assignment(),
        "Half the weighted squared error of the continuous factors and selected components.");
}

}  // namespace hybrid::python
