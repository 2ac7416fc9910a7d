// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/discrete/inference.h"
#include "libhybrid/discrete/probabilities.h"
#include "libhybrid/discrete/table.h"
#include "libhybrid/hybrid/semantic.h"
#include "python/fields.h"

namespace hybrid::python {
namespace {

using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

std::vector<double> flat(const Numbers& array) {
  return {array.data(), array.data() + array.size()};
}

/// A view of the costs with one axis per variable; `owner` keeps them alive.
py::array costs(const py::object& owner) {
  const auto& table = owner.cast<const Table&>();
  std::vector<py::ssize_t> shape;
  for (const DiscreteKey& key : table.keys()) shape.push_back(key.cardinality);
  py::array view(py::dtype::of<double>(), shape, table.costs().data(), owner);
  view.attr("flags").attr("writeable") = false;
  return view;
}

std::vector<const Table*> pointers(const std::vector<Table>& tables) {
  std::vector<const Table*> all;
  for (const Table& table : tables) all.push_back(&table);
  return all;
}

void bind_tables(py::module_& m) {
  py::class_<Table>(m, "Table",
                    "A discrete factor: a cost -log f (+inf if impossible) for each joint value of "
                    "its variables.")
      .def(py::init([](std::vector<DiscreteKey> keys, const Numbers& costs) {
             return Table(std::move(keys), flat(costs));
           }),
           "keys"_a, "costs"_a,
           "Costs with one axis per variable, or flat with the first variable varying slowest.")
      .def_property_readonly("keys", &Table::keys)
      .def_property_readonly("costs", &costs, "Costs with one axis per variable; a read-only view.")
      .def("cost", &Table::cost, "assignment"_a)
      .def(
          py::pickle([](const Table& table) { return py::make_tuple(table.keys(), table.costs()); },
                     [](const py::tuple& state) {
                       return Table(state[0].cast<std::vector<DiscreteKey>>(),
                                    state[1].cast<std::vector<double>>());
                     }))
      .def("__repr__", [](const Table& table) {
        std::string text = "<Table over";
        for (const DiscreteKey& key : table.keys()) text += " " + to_string(key.key);
        return text + ">";
      });
  m.def(
      "potential_table",
      [](std::vector<DiscreteKey> keys, const Numbers& potentials) {
        return potential_table(std::move(keys), flat(potentials));
      },
      "keys"_a, "potentials"_a, "A table from potentials f >= 0, one axis per variable.");
  m.def(
      "conditional_table",
      [](DiscreteKey child, const std::vector<DiscreteKey>& parents, const Numbers& p) {
        return conditional_table(child, parents, flat(p));
      },
      "child"_a, "parents"_a, "probabilities"_a,
      "p(child | parents): one axis per parent, then one for the child, over which it sums to "
      "one.");
  m.def("prior_table", &prior_table, "key"_a, "probabilities"_a,
        "The probabilities (cardinality,) of a variable.");
  m.def(
      "transition_table",
      [](DiscreteKey from, DiscreteKey to, const Numbers& p) {
        return transition_table(from, to, flat(p));
      },
      "from_key"_a, "to_key"_a, "probabilities"_a,
      "p(to | from) (cardinality of from, cardinality of to) of a Markov chain.");
  m.def("likelihood_table", &likelihood_table, "class_key"_a, "likelihood"_a,
        "The likelihood (classes,) of a detector's output, for each true class (phi of eq. 19).");
  m.def("likelihood_of_detection", &likelihood_of_detection, "confusion"_a, "detected"_a,
        "A column of a confusion matrix (classes, classes) whose rows are p(reports d | true s).");
  m.def("likelihood_of_scores", &likelihood_of_scores, "scores"_a,
        "prior"_a = std::vector<double>(), "floor"_a = 1e-6,
        "The likelihood of each class: scores p(s | image) divided by the class frequencies in the "
        "detector's training data (uniform if empty).");
}

}  // namespace

void bind_discrete(py::module_& m) {
  bind_tables(m);
  FieldsClass<DiscreteSolution>(m, "DiscreteSolution", "The joint values of least total cost.")
      .def_readonly("assignment", &DiscreteSolution::assignment)
      .def_readonly("cost", &DiscreteSolution::cost, "Sum of the costs of all tables.")
      .def_readonly("exact", &DiscreteSolution::exact,
                    "False if local search replaced elimination.")
      .def_readonly(
          "impossible", &DiscreteSolution::impossible,
          "Variables of tables that exclude every joint value; empty if there is a solution.");
  m.def(
      "solve_discrete",
      [](const std::vector<Table>& tables) { return solve_discrete(pointers(tables)); }, "tables"_a,
      Unlocked(), "The joint values of least total cost (eq. 9a), by elimination.");
  py::class_<DiscreteMarginals>(m, "DiscreteMarginals", "Marginals of discrete variables, by key.")
      .def(
          "__getitem__", [](const DiscreteMarginals& d, Key key) { return d.at(key); }, "key"_a,
          py::return_value_policy::reference_internal,
          "Probability of each value (cardinality,); a read-only view.")
      .def("__contains__", &DiscreteMarginals::contains, "key"_a)
      .def("__len__", &DiscreteMarginals::size)
      .def_property_readonly("log_partition", &DiscreteMarginals::log_partition,
                             "Logarithm of the sum of exp(-cost) over all joint values.");
  m.def(
      "table_marginals",
      [](const std::vector<Table>& tables) { return discrete_marginals(pointers(tables)); },
      "tables"_a, Unlocked(), "Exact marginals of all variables of the tables.");
}

}  // namespace hybrid::python
