// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/solvers/alternating.h"
#include "libhybrid/solvers/certificate.h"
#include "libhybrid/solvers/chordal.h"
#include "libhybrid/solvers/dogleg.h"
#include "libhybrid/solvers/exhaustive.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "libhybrid/solvers/null_space.h"
#include "python/calls.h"
#include "python/fields.h"

namespace hybrid::python {
namespace {

void bind_options(py::module_& m) {
  SettingsClass<SolverOptions>(m, "SolverOptions", "Settings of the continuous solvers.")
      .described();
  SettingsClass<DiscreteOptions>(m, "DiscreteOptions", "Settings of discrete inference.")
      .field("local_search_when_too_large", &DiscreteOptions::local_search_when_too_large,
             "Use local search if exact inference is too large; else raise Error.")
      .field("max_sweeps", &DiscreteOptions::max_sweeps,
             "Largest number of sweeps of local search.");
  SettingsClass<AlternatingOptions>(m, "AlternatingOptions", "Settings of `alternate`.")
      .described();
}

void bind_reports(py::module_& m) {
  py::enum_<SolverStatus>(m, "SolverStatus", "How a solve ended.")
      .value("CONVERGED", SolverStatus::kConverged)
      .value("ITERATION_LIMIT", SolverStatus::kIterationLimit)
      .value("UNDER_CONSTRAINED", SolverStatus::kUnderConstrained)
      .value("NOT_FINITE", SolverStatus::kNotFinite)
      .value("STALLED", SolverStatus::kStalled);
  FieldsClass<SolverReport>(m, "SolverReport", "The report of a continuous solver.")
      .def_readonly("status", &SolverReport::status)
      .def_readonly("iterations", &SolverReport::iterations, "Linear systems solved.")
      .def_readonly("costs", &SolverReport::costs,
                    "Cost at the start and after each accepted step.")
      .def_readonly("seconds", &SolverReport::seconds)
      .def_readonly("message", &SolverReport::message)
      .def_readonly("under_constrained", &SolverReport::under_constrained,
                    "Variables that the factors do not determine.");
  FieldsClass<SolverResult>(m, "SolverResult", "The result of a continuous solver.")
      .def_readonly("values", &SolverResult::values)
      .def_readonly("report", &SolverResult::report);
  FieldsClass<HalfStep>(m, "HalfStep", "The joint objective after a half-step.")
      .def_readonly("discrete", &HalfStep::discrete)
      .def_readonly("objective", &HalfStep::objective)
      .def_readonly("changes", &HalfStep::changes,
                    "Number of discrete variables that changed, or of continuous iterations.");
  FieldsClass<AlternatingReport>(m, "AlternatingReport", "The report of the alternation.")
      .def_readonly("status", &AlternatingReport::status)
      .def_readonly("iterations", &AlternatingReport::iterations, "Pairs of half-steps.")
      .def_readonly("initial_objective", &AlternatingReport::initial_objective)
      .def_readonly("objective", &AlternatingReport::objective, "Objective of eq. 6.")
      .def_readonly("cost", &AlternatingReport::cost, "Half the weighted squared error.")
      .def_readonly("half_steps", &AlternatingReport::half_steps,
                    "All half-steps; the objective never rises (eq. 10).")
      .def_readonly("discrete_exact", &AlternatingReport::discrete_exact)
      .def_readonly("last_solve", &AlternatingReport::last_solve)
      .def_readonly("seconds", &AlternatingReport::seconds)
      .def_readonly("message", &AlternatingReport::message);
  FieldsClass<AlternatingResult>(m, "AlternatingResult", "The result of the alternation.")
      .def_readonly("estimate", &AlternatingResult::estimate)
      .def_readonly("report", &AlternatingResult::report);
  FieldsClass<ExhaustiveResult>(m, "ExhaustiveResult",
                                "The result of an exhaustive search over assignments.")
      .def_readonly("estimate", &ExhaustiveResult::estimate)
      .def_readonly("objective", &ExhaustiveResult::objective)
      .def_readonly("keys", &ExhaustiveResult::keys)
      .def_readonly("objectives", &ExhaustiveResult::objectives,
                    "Objective by joint value of `keys`, the first varying slowest.");
  FieldsClass<FreeVariable>(m, "FreeVariable", "A variable that the factors do not determine.")
      .def_readonly("key", &FreeVariable::key)
      .def_readonly("directions", &FreeVariable::directions,
                    "Basis (dim, k) of its undetermined directions, in its tangent.");
}

void bind_certificate(py::module_& m) {
  FieldsClass<Certificate>(m, "Certificate",
                           "Certificate of optimality of an estimate of a pose graph.")
      .def_readonly("verified", &Certificate::verified,
                    "Whether no poses cost less, up to `stated_gap`.")
      .def_readonly("isotropic_verified", &Certificate::isotropic_verified,
                    "The same of the isotropic problem alone, up to `relative_gap`.")
      .def_readonly("stated_gap", &Certificate::stated_gap,
                    "How much less other poses cost at most by the factors as stated, as a share; "
                    "1 if nothing is proven of them.")
      .def_readonly("min_eigenvalue", &Certificate::min_eigenvalue)
      .def_readonly("relative_gap", &Certificate::relative_gap)
      .def_readonly("cost", &Certificate::cost, "Cost of the isotropic problem.")
      .def_readonly("message", &Certificate::message, "Why nothing could be computed, or empty.");
  m.def(
      "certify",
      [](const HybridGraph& graph, const Values& estimate) {
        if (graph.hybrid().size() + graph.discrete().size() > 0) {
          throw Error(
              "a certificate is of continuous factors: give those of the chosen components as a "
              "list");
        }
        std::vector<ContinuousFactorPtr> factors;
        graph.continuous().for_each([&](Handle, const auto& f) { factors.push_back(f); });
        return call_on_copies([](const auto&... arguments) { return certify(arguments...); },
                              factors, estimate);
      },
      "graph"_a, "estimate"_a, "Of a graph of continuous factors.");
  m.def(
      "certify",
      [](const std::vector<FactorArgument>& factors, const Values& estimate) {
        const std::vector<ContinuousFactorPtr> pointers = to_pointers(factors);
        return call_on_copies([](const auto&... arguments) { return certify(arguments...); },
                              pointers, estimate);
      },
      "factors"_a, "estimate"_a,
      "Whether an estimate lies in the basin of the global optimum of its relative poses, by the "
      "dual certificate of SE-Sync.");
  FieldsClass<StaircaseResult>(m, "StaircaseResult", "The result of `climb_staircase`.")
      .def_readonly("values", &StaircaseResult::values, "The estimate, or poses that cost less.")
      .def_readonly("certificate", &StaircaseResult::certificate, "The certificate of these.")
      .def_readonly("cost_before", &StaircaseResult::cost_before)
      .def_readonly("cost", &StaircaseResult::cost, "Of the factors as stated.")
      .def_readonly("levels", &StaircaseResult::levels, "Ranks tried above that of rotations.");
  m.def(
      "climb_staircase",
      [](const std::vector<FactorArgument>& factors, const Values& estimate) {
        const std::vector<ContinuousFactorPtr> pointers = to_pointers(factors);
        return call_on_copies(
            [](const auto&... arguments) { return climb_staircase(arguments...); }, pointers,
            estimate);
      },
      "factors"_a, "estimate"_a,
      "The same, and where the estimate is not verified, a search for poses that cost less by the "
      "Riemannian staircase.");
}

}  // namespace

void bind_solvers(py::module_& m) {
  bind_options(m);
  bind_reports(m);
  bind_certificate(m);
  m.def(
      "alternate",
      [](const HybridGraph& graph, const Estimate& initial, const AlternatingOptions& options) {
        return call_on_copies([](const auto&... arguments) { return alternate(arguments...); },
                              graph, initial, options);
      },
      "graph"_a, "initial"_a, "options"_a = AlternatingOptions(),
      "Alternating minimisation of the joint objective (eq. 8-10): the exact discrete half-step, "
      "then Levenberg-Marquardt, until neither changes anything.");
  m.def("levenberg_marquardt",
        on_copies(py::overload_cast<const HybridGraph&, const Estimate&, const SolverOptions&>(
            &levenberg_marquardt)),
        "graph"_a, "initial"_a, "options"_a = SolverOptions(),
        "Minimises the continuous variables for a fixed assignment (eq. 8b).");
  m.def("dogleg",
        on_copies(
            py::overload_cast<const HybridGraph&, const Estimate&, const SolverOptions&>(&dogleg)),
        "graph"_a, "initial"_a, "options"_a = SolverOptions(),
        "Minimises the continuous variables for a fixed assignment by Powell's dogleg.");
  m.def("solve_exhaustive",
        on_copies(py::overload_cast<const HybridGraph&, const Values&, const SolverOptions&>(
            &solve_exhaustive)),
        "graph"_a, "initial"_a, "options"_a = SolverOptions(),
        "The joint minimum by trying every assignment, for small graphs.");
  m.def(
      "chordal_initialization",
      [](const std::vector<FactorArgument>& factors, const Values& initial) {
        const std::vector<ContinuousFactorPtr> pointers = to_pointers(factors);
        return call_on_copies(
            [](const auto&... arguments) { return chordal_initialization(arguments...); }, pointers,
            initial);
      },
      "factors"_a, "initial"_a,
      "Initial values from all relative poses among the factors, by two linear problems. Poses "
      "with "
      "a prior, or the first pose if none has one, stay at their initial values.");
  m.def(
      "free_variables",
      [](const HybridGraph& graph, const Estimate& estimate) {
        return call_on_copies([](const auto&... arguments) { return free_variables(arguments...); },
                              graph, estimate);
      },
      "graph"_a, "estimate"_a, "The variables that the factors do not determine at an estimate.");
}

}  // namespace hybrid::python
