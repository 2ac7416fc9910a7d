// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <pybind11/functional.h>

#include "libhybrid/closures/objective_bound.h"
#include "libhybrid/methods/robust_methods.h"
#include "libhybrid/online/online_selection.h"
#include "libhybrid/selection/closure_agreement.h"
#include "libhybrid/selection/closure_selection.h"
#include "python/calls.h"
#include "python/fields.h"
#include "python/garbage.h"

namespace hybrid::python {
namespace {

struct ProblemAccess {
  static int visit(const RobustProblem& problem, visitproc visit, void* argument) {
    const int stop = visit_factors(problem.trusted, visit, argument);
    return stop != 0 ? stop : visit_factors(problem.closures, visit, argument);
  }
  static void clear(RobustProblem& problem) {
    const RobustProblem gone = std::exchange(problem, RobustProblem());
  }
};

void bind_problem(py::module_& m) {
  FieldsClass<RobustProblem>(m, "RobustProblem",
                             "Trusted factors, and closures that may be false (eq. 16).",
                             collected<RobustProblem, ProblemAccess>())
      .def(py::init([](const std::vector<FactorArgument>& trusted,
                       const std::vector<FactorArgument>& closures, const Values& initial) {
             return RobustProblem{to_pointers(trusted), to_pointers(closures), initial};
           }),
           "trusted"_a, "closures"_a, "initial"_a)
      .def_readonly("trusted", &RobustProblem::trusted)
      .def_readonly("closures", &RobustProblem::closures)
      .def_readwrite("initial", &RobustProblem::initial);
  py::enum_<ClosureStatus>(m, "ClosureStatus", "What was decided about a closure.")
      .value("REJECTED", ClosureStatus::kRejected)
      .value("UNDECIDED", ClosureStatus::kUndecided)
      .value("ACCEPTED", ClosureStatus::kAccepted)
      .value("TRUSTED", ClosureStatus::kTrusted);
  FieldsClass<ClosureDecision>(m, "ClosureDecision", "The decision on one closure.")
      .def_readonly("status", &ClosureDecision::status)
      .def_property_readonly("accepted", &ClosureDecision::accepted)
      .def_readonly("inlier_probability", &ClosureDecision::inlier_probability)
      .def_readonly("chi_square", &ClosureDecision::chi_square, "Squared whitened residual.")
      .def_readonly("redundancy", &ClosureDecision::redundancy,
                    "How far other factors check this one, in [0, 1].")
      .def_readonly("checkable", &ClosureDecision::checkable)
      .def_readonly("evidence", &ClosureDecision::evidence,
                    "Log evidence relative to that for a false closure.")
      .def_readonly("margin", &ClosureDecision::margin,
                    "Excess of the log evidence over its threshold.");
  FieldsClass<RobustResult>(m, "RobustResult", "The result of a robust method.")
      .def_readonly("method", &RobustResult::method)
      .def_readonly("values", &RobustResult::values)
      .def_readonly("decisions", &RobustResult::decisions,
                    "Decisions in the order of the closures.")
      .def_property_readonly(
          "accepted",
          [](const RobustResult& result) {
            py::array_t<bool> accepted(static_cast<py::ssize_t>(result.decisions.size()));
            for (std::size_t k = 0; k < result.decisions.size(); ++k) {
              accepted.mutable_at(k) = result.decisions[k].accepted();
            }
            return accepted;
          },
          "Whether each closure is accepted, (n,) of bool.")
      .def_readonly("objective", &RobustResult::objective,
                    "Objective of eq. 6 with the mixtures of eq. 17.")
      .def_readonly("cost", &RobustResult::cost, "Cost of trusted and accepted factors.")
      .def_readonly("iterations", &RobustResult::iterations, "Linear systems solved.")
      .def_readonly("seconds", &RobustResult::seconds)
      .def_readonly("converged", &RobustResult::converged)
      .def_readonly("message", &RobustResult::message)
      .def_readonly("objectives", &RobustResult::objectives,
                    "Objective of the method, at the start and after each macro-step.")
      .def_readonly("variance_factor", &RobustResult::variance_factor,
                    "Estimated factor by which the variances of the noise are understated.");
  m.def("to_robust_problem", &to_robust_problem, "graph"_a, "initial"_a, "trusted"_a = Trust(),
        "options"_a = GraphFactorOptions(),
        "A pose graph as a robust problem. Relative poses are closures unless "
        "trusted(from_key, to_key); by default, those between successive poses are trusted.");
}

void bind_options(py::module_& m) {
  SettingsClass<MixtureOptions>(m, "MixtureOptions", "Model of false closures (eq. 17).")
      .described();
  SettingsClass<ClosureSelectionOptions>(m, "ClosureSelectionOptions",
                                         "Settings of `select_closures`.")
      .described();
  SettingsClass<OnlineSelectionOptions>(m, "OnlineSelectionOptions", "Settings of OnlineSelection.")
      .described();
}

void bind_batch(py::module_& m) {
  m.def("select_closures", on_copies(&select_closures), "problem"_a,
        "options"_a = ClosureSelectionOptions(),
        "Loop closure selection, the project's own method.");
  m.def(
      "robust_methods",
      [] {
        std::map<std::string, std::string> methods;
        for (const RobustMethod& method : robust_methods()) methods[method.name] = method.meaning;
        return methods;
      },
      "Names and meanings of all robust methods.");
  m.def(
      "solve_robust",
      [](const RobustProblem& problem, const std::string& method, const MixtureOptions& mixture,
         const std::vector<bool>& truth, int threads) {
        MethodOptions options;
        options.set_mixture(mixture);
        options.set_threads(threads);
        const auto solve = [&](const RobustProblem& p) {
          return robust_method(method).solve({p, truth, {}}, options);
        };
        return call_on_copies(solve, problem);
      },
      "problem"_a, "method"_a = "selection", "mixture"_a = MixtureOptions(),
      "truth"_a = std::vector<bool>(), "threads"_a = 0,
      "Solves by a method of `robust_methods`, with the default settings of the programs. "
      "`truth` (whether each closure is true) is for the method 'oracle'.");
  FieldsClass<ObjectiveBound>(m, "ObjectiveBound",
                              "A lower bound on the joint objective of a robust problem.")
      .def_readonly("bound", &ObjectiveBound::bound,
                    "No poses and no decisions have a lower objective.")
      .def_readonly("gap", &ObjectiveBound::gap,
                    "Objective of the given estimate minus the bound, not negative.")
      .def_readonly("solves", &ObjectiveBound::solves, "Relaxations solved.")
      .def_readonly("complete", &ObjectiveBound::complete,
                    "Whether the search ended before the budget.");
  m.def("bound_objective", on_copies(&bound_objective), "problem"_a, "values"_a, "accepted"_a,
        "mixture"_a = MixtureOptions(), "budget"_a = 100,
        "Bounds how much lower the joint objective can be for any poses and any decisions about "
        "the closures, by branch and bound over the decisions and certificates of the poses. After "
        "`budget` relaxations the bound reached is returned, which is valid, too.");
}

/// An evaluation that is under way ends with its selection. Its thread may call factors written in
/// Python, which needs the lock of the interpreter.
struct WithoutLock {
  void operator()(OnlineSelection* selection) const {
    const py::gil_scoped_release unlocked;
    delete selection;
  }
};

void bind_agreement(py::module_& m) {
  FieldsClass<ClosureAgreement>(m, "ClosureAgreement",
                                "Whether closures measured at different times agree with the path.")
      .def_readonly("agreeing", &ClosureAgreement::agreeing,
                    "Passages that the rest of the map predicts.")
      .def_readonly("rivals", &ClosureAgreement::rivals,
                    "Passages that the map contradicts, and others agree with.")
      .def_readonly("alone", &ClosureAgreement::alone,
                    "Passages that the map contradicts, and nothing supports.")
      .def_readonly("ratio", &ClosureAgreement::ratio,
                    "agreeing / (agreeing + rivals), nan where there are none of both.")
      .def_readonly("rival_closures", &ClosureAgreement::rival_closures,
                    "Numbers of closures, one of each rival passage, the most supported first.");
  m.def(
      "agreement_of_closures",
      [](const RobustProblem& problem, const Values& values, const std::vector<bool>& accepted,
         double scale) {
        const auto judge = [&](const RobustProblem& p) {
          return agreement_of_closures(p, values, accepted, scale);
        };
        return call_on_copies(judge, problem);
      },
      "problem"_a, "values"_a, "accepted"_a, "scale"_a = 1.0,
      "Whether closures that were measured far apart in time agree with an estimate that rests on "
      "those accepted, (n,) of bool. Residuals may be `scale` times what the information says.");
}

void bind_online(py::module_& m) {
  FieldsClass<SelectionReport, UpdateReport>(m, "SelectionReport", "The report of an update.")
      .def_readonly("admitted", &SelectionReport::admitted, "Closures admitted.")
      .def_readonly("tried", &SelectionReport::tried);
  py::class_<OnlineSelection, std::unique_ptr<OnlineSelection, WithoutLock>>(
      m, "OnlineSelection",
      "Selects among closures that arrive pose by pose, on the incremental smoother.")
      .def(py::init<const OnlineSelectionOptions&>(), "options"_a = OnlineSelectionOptions())
      .def(
          "update",
          [](OnlineSelection& selection, const Delta& trusted,
             const std::vector<FactorArgument>& closures,
             const std::vector<std::size_t>& alternatives) {
            const std::vector<ContinuousFactorPtr> pointers = to_pointers(closures);
            Alternatives sets;
            for (const std::size_t first : alternatives) sets.add(first);
            return changing(&OnlineSelection::update)(selection, trusted, pointers, sets);
          },
          "trusted"_a, "closures"_a = py::list(), "alternatives"_a = py::list(),
          "Applies a change of trusted factors and tests new closures, which are numbered in the "
          "order of arrival. `alternatives` has for each of them the place in this update of the "
          "first one of those of which at most one is true.")
      .def("finish", changing(&OnlineSelection::finish),
           "Evaluates all closures again, and solves to convergence.")
      .def_property_readonly("smoother", &OnlineSelection::smoother,
                             py::return_value_policy::reference_internal,
                             "The smoother, to read; update the selection, not the smoother.")
      .def("evaluating", reading(&OnlineSelection::evaluating),
           "Whether an evaluation of all closures is under way.")
      .def("status", reading(&OnlineSelection::status), "closure"_a)
      .def("decisions", reading(&OnlineSelection::decisions), "Decisions by closure.");
}

}  // namespace

void bind_selection(py::module_& m) {
  bind_problem(m);
  bind_options(m);
  bind_batch(m);
  bind_agreement(m);
  bind_online(m);
}

}  // namespace hybrid::python
