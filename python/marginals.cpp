// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/marginals/continuous.h"
#include "libhybrid/marginals/discrete.h"
#include "libhybrid/marginals/evidence.h"
#include "libhybrid/marginals/posterior.h"
#include "python/calls.h"
#include "python/fields.h"

namespace hybrid::python {
namespace {

void bind_covariances(py::module_& m) {
  py::class_<Covariances>(m, "Covariances", "Covariance blocks of many variables, by key.")
      .def(
          "__getitem__", [](const Covariances& c, Key key) { return c.at(key); }, "key"_a,
          py::return_value_policy::reference_internal,
          "Covariance (dim, dim) over the tangent of the variable; a read-only view.")
      .def("__contains__", &Covariances::contains, "key"_a)
      .def("__len__", &Covariances::size)
      .def("keys", &Covariances::keys, "Sorted.")
      .def(
          "__iter__", [](const Covariances& c) { return py::iter(py::cast(c.keys())); },
          "The keys, sorted.")
      .def("__repr__",
           [](const Covariances& c) {
             return "<Covariances of " + std::to_string(c.size()) + " variables>";
           })
      .def("__copy__", [](const Covariances& c) { return Covariances(c); })
      .def(py::pickle(
          [](const Covariances& c) {
            py::list blocks;
            for (const Key key : c.keys()) {
              blocks.append(py::make_tuple(key, Eigen::MatrixXd(c.at(key))));
            }
            return blocks;
          },
          [](const py::list& blocks) {
            Covariances made;
            for (const auto& [key, block] :
                 blocks.cast<std::vector<std::pair<Key, Eigen::MatrixXd>>>()) {
              made.insert(key, block);
            }
            return made;
          }));
}

/// Marginals that remember what they are of, for pickles: their factorisation has no form there.
struct KeptMarginals : ContinuousMarginals {
  KeptMarginals(const HybridGraph& g, const Estimate& e, int count)
      : ContinuousMarginals(g, e, MarginalOptions{count}), graph(g), estimate(e), threads(count) {}

  HybridGraph graph;
  Estimate estimate;
  int threads;
};

std::unique_ptr<KeptMarginals> factorised(const HybridGraph& graph, const Estimate& estimate,
                                          int threads) {
  const auto make = [](const HybridGraph& g, const Estimate& e, int count) {
    return std::make_unique<KeptMarginals>(g, e, count);
  };
  return call_on_copies(make, graph, estimate, threads);
}

void bind_continuous(py::module_& m) {
  py::class_<KeptMarginals>(m, "ContinuousMarginals",
                            "Laplace approximation of the continuous marginals given the "
                            "assignment (eq. 11b to 14), over "
                            "the tangents at the estimate. Factorised once; a pickle holds "
                            "graph and estimate, and they are factorised again.")
      .def(py::init(&factorised), "graph"_a, "estimate"_a, "threads"_a = 0)
      .def_property_readonly("valid", &KeptMarginals::valid,
                             "Whether the factors determine all variables.")
      .def_property_readonly("under_constrained", &KeptMarginals::under_constrained)
      .def("covariance", &KeptMarginals::covariance, "key"_a, Unlocked(),
           "Covariance (dim, dim) of a variable.")
      .def("joint_covariance", &KeptMarginals::joint_covariance, "keys"_a, Unlocked(),
           "Joint covariance of variables, in the given order.")
      .def("all", &KeptMarginals::all, Unlocked(),
           "Covariances of all variables that the factors determine, by selected inversion.")
      .def("__copy__", [](const py::object& self) { return self; })  // it never changes
      .def(
          "__deepcopy__", [](const py::object& self, const py::dict&) { return self; }, "memo"_a)
      .def(py::pickle(
          [](const KeptMarginals& m) { return py::make_tuple(m.graph, m.estimate, m.threads); },
          [](const py::tuple& of) {
            return factorised(of[0].cast<HybridGraph>(), of[1].cast<Estimate>(), of[2].cast<int>());
          }));
}

void bind_posterior(py::module_& m) {
  SettingsClass<PosteriorOptions>(m, "PosteriorOptions",
                                  "Limits of enumeration and precision of sampling.")
      .field("max_assignments", &PosteriorOptions::max_assignments,
             "Largest number of joint values to enumerate; beyond it, they are sampled.")
      .field("window", &PosteriorOptions::window, "Variables sampled together.")
      .field("standard_error", &PosteriorOptions::standard_error,
             "Required standard error of sampled probabilities.")
      .field("max_sweeps", &PosteriorOptions::max_sweeps, "Largest number of sampling sweeps.")
      .field("seed", &PosteriorOptions::seed, "Seed of the sampling.");
  FieldsClass<DiscreteProbabilities>(m, "DiscreteProbabilities",
                                     "The probabilities of one discrete variable.")
      .kept("p", &DiscreteProbabilities::p)
      .def_property_readonly(
          "p",
          [](const DiscreteProbabilities& d) {
            return py::array_t<double>(d.p.size(), d.p.data());
          },
          "Probability of each value (cardinality,).")
      .def_readonly("standard_error", &DiscreteProbabilities::standard_error,
                    "Standard error of each probability if sampled; empty if enumerated.");
  FieldsClass<AssignmentPosterior>(m, "AssignmentPosterior",
                                   "The posterior of discrete variables, with the continuous ones "
                                   "integrated out.")
      .kept("variables", &AssignmentPosterior::variables)
      .def("__getitem__", &AssignmentPosterior::at, "key"_a, "The probabilities of one variable.",
           py::return_value_policy::reference_internal)
      .def_readonly("joint", &AssignmentPosterior::joint,
                    "Probability of each joint value, the first variable varying slowest; empty if "
                    "sampled.")
      .def_readonly("exact", &AssignmentPosterior::exact, "False if sampled.")
      .def_readonly("undetermined", &AssignmentPosterior::undetermined,
                    "Discrete variables with a value that leaves continuous ones undetermined.")
      .def_readonly("under_constrained", &AssignmentPosterior::under_constrained);
  m.def(
      "posterior",
      [](const HybridGraph& graph, const Estimate& estimate, const std::vector<Key>& keys,
         const PosteriorOptions& options) {
        return call_on_copies([](const auto&... arguments) { return posterior(arguments...); },
                              graph, estimate, keys, options);
      },
      "graph"_a, "estimate"_a, "keys"_a, "options"_a = PosteriorOptions(),
      "p(D | Z) of discrete variables: every joint value is weighted by its evidence.");
  m.def(
      "posterior_marginals",
      [](const HybridGraph& graph, const Estimate& estimate, const std::vector<Key>& keys,
         const PosteriorOptions& options) {
        return call_on_copies(
            [](const auto&... arguments) { return posterior_marginals(arguments...); }, graph,
            estimate, keys, options);
      },
      "graph"_a, "estimate"_a, "keys"_a, "options"_a = PosteriorOptions(),
      "p(d | Z, others) of each of several discrete variables: others that no table connects with "
      "it have the values of the estimate. That is p(d | Z) unless they share continuous "
      "variables; "
      "`posterior` of several such together sums over all of them.");
}

}  // namespace

void bind_marginals(py::module_& m) {
  bind_covariances(m);
  bind_continuous(m);
  bind_posterior(m);
  m.def(
      "discrete_marginals",
      [](const HybridGraph& graph, const Values& values) {
        return call_on_copies(
            [](const HybridGraph& g, const Values& v) { return discrete_marginals(g, v); }, graph,
            values);
      },
      "graph"_a, "values"_a,
      "Exact marginals of the discrete variables given the continuous ones (eq. 11a).");
  FieldsClass<Evidence>(m, "Evidence", "The evidence of an assignment.")
      .def_readonly("log", &Evidence::log,
                    "Logarithm of the evidence; None if the assignment leaves variables "
                    "undetermined.")
      .def_readonly("under_constrained", &Evidence::under_constrained);
  m.def("log_evidence", on_copies(&log_evidence), "graph"_a, "estimate"_a, "threads"_a = 0,
        "The Laplace approximation of the evidence of the assignment of an estimate whose "
        "continuous values minimise the objective for it.");
}

}  // namespace hybrid::python
