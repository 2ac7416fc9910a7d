// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/marginals/continuous.h"
#include "libhybrid/marginals/discrete.h"
#include "libhybrid/marginals/evidence.h"
#include "libhybrid/marginals/posterior.h"
#include "python/bindings.h"

namespace hybrid::python {
namespace {

void bind_continuous(py::module_& m) {
  py::class_<Covariances>(m, "Covariances", "Covariance blocks of many variables, by key.")
      .def(
          "__getitem__", [](const Covariances& c, Key key) { return c.at(key); }, "key"_a,
          py::return_value_policy::reference_internal,
          "(dim, dim) over the tangent of the variable; a view, not to be written.")
      .def("__contains__", &Covariances::contains, "key"_a)
      .def("__len__", &Covariances::size);
  py::class_<ContinuousMarginals>(m, "ContinuousMarginals",
                                  "Laplace approximation of the continuous marginals given the "
                                  "assignment (eq. 11b to 14), over "
                                  "the tangents at the estimate. Factorised once.")
      .def(py::init([](const HybridGraph& graph, const Estimate& estimate, int threads) {
             return std::make_unique<ContinuousMarginals>(graph, estimate,
                                                          MarginalOptions{threads});
           }),
           "graph"_a, "estimate"_a, "threads"_a = 0, Unlocked())
      .def_property_readonly("valid", &ContinuousMarginals::valid,
                             "Whether the factors determine all variables.")
      .def_property_readonly("under_constrained", &ContinuousMarginals::under_constrained)
      .def("covariance", &ContinuousMarginals::covariance, "key"_a, Unlocked(), "(dim, dim).")
      .def("joint_covariance", &ContinuousMarginals::joint_covariance, "keys"_a, Unlocked(),
           "Of some variables, in the order given.")
      .def("all", &ContinuousMarginals::all, Unlocked(),
           "Of all variables that the factors determine, by selected inversion.");
}

void bind_posterior(py::module_& m) {
  SettingsClass<PosteriorOptions>(m, "PosteriorOptions",
                                  "How far enumeration goes, and how well sampling estimates.")
      .field("max_assignments", &PosteriorOptions::max_assignments,
             "Joint values that are enumerated; more are sampled.")
      .field("window", &PosteriorOptions::window, "Variables sampled together.")
      .field("standard_error", &PosteriorOptions::standard_error, "Of sampled probabilities.")
      .field("max_sweeps", &PosteriorOptions::max_sweeps, "Of sampling.")
      .field("seed", &PosteriorOptions::seed, "Of sampling.");
  py::class_<DiscreteProbabilities>(m, "DiscreteProbabilities",
                                    "What is known of one discrete variable.")
      .def_property_readonly(
          "p",
          [](const DiscreteProbabilities& d) {
            return py::array_t<double>(d.p.size(), d.p.data());
          },
          "(cardinality,).")
      .def_readonly("standard_error", &DiscreteProbabilities::standard_error,
                    "Of each, by sampling; empty where enumerated.");
  py::class_<AssignmentPosterior>(m, "AssignmentPosterior",
                                  "The posterior of some discrete variables, the continuous ones "
                                  "integrated out.")
      .def("__getitem__", &AssignmentPosterior::at, "key"_a, "Of one variable.",
           py::return_value_policy::reference_internal)
      .def_readonly("joint", &AssignmentPosterior::joint,
                    "Of the joint values, the first variable varying slowest; empty where sampled.")
      .def_readonly("exact", &AssignmentPosterior::exact, "False where sampled.")
      .def_readonly("undetermined", &AssignmentPosterior::undetermined,
                    "Discrete variables some value of which leaves continuous ones undetermined.")
      .def_readonly("under_constrained", &AssignmentPosterior::under_constrained);
  m.def(
      "posterior",
      [](const HybridGraph& graph, const Estimate& estimate, const std::vector<Key>& keys,
         const PosteriorOptions& options) { return posterior(graph, estimate, keys, options); },
      "graph"_a, "estimate"_a, "keys"_a, "options"_a = PosteriorOptions(), Unlocked(),
      "p(D | Z) of some discrete variables: every joint value counts with its evidence.");
  m.def(
      "posterior_marginals",
      [](const HybridGraph& graph, const Estimate& estimate, const std::vector<Key>& keys,
         const PosteriorOptions& options) {
        return posterior_marginals(graph, estimate, keys, options);
      },
      "graph"_a, "estimate"_a, "keys"_a, "options"_a = PosteriorOptions(), Unlocked(),
      "p(d | Z) of each of some discrete variables.");
}

}  // namespace

void bind_marginals(py::module_& m) {
  bind_continuous(m);
  bind_posterior(m);
  m.def(
      "discrete_marginals",
      [](const HybridGraph& graph, const Values& values) {
        return discrete_marginals(graph, values);
      },
      "graph"_a, "values"_a, Unlocked(),
      "Exact marginals of the discrete variables given the continuous ones (eq. 11a).");
  py::class_<Evidence>(m, "Evidence", "What the data say of an assignment.")
      .def_readonly("log", &Evidence::log,
                    "None where the assignment leaves variables undetermined.")
      .def_readonly("under_constrained", &Evidence::under_constrained);
  m.def("log_evidence", &log_evidence, "graph"_a, "estimate"_a, "threads"_a = 0, Unlocked(),
        "The Laplace approximation of the evidence of the assignment of an estimate whose "
        "continuous values minimise the objective for it.");
}

}  // namespace hybrid::python
