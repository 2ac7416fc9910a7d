// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/report/graph_report.h"

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "mrpt_plugins/report/columns.h"

namespace hybrid {
namespace {

using Json = nlohmann::ordered_json;

Json closures_json(const std::vector<GraphReport::Closure>& closures) {
  Json out = Json::object();
  for (const char* name :
       {"i", "j", "decision", "probability", "residual", "redundancy", "margin", "checkable"}) {
    out[name] = Json::array();
  }
  for (const GraphReport::Closure& c : closures) {
    out["i"].push_back(c.from);
    out["j"].push_back(c.to);
    out["decision"].push_back(c.decision);
    out["probability"].push_back(digits(c.probability));
    out["residual"].push_back(digits(c.residual));
    out["redundancy"].push_back(digits(c.redundancy));
    out["margin"].push_back(digits(c.margin));
    out["checkable"].push_back(c.checkable ? 1 : 0);
  }
  return out;
}

/// A number where the whole text is one.
Json value_json(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  return text.empty() || *end != '\0' ? Json(text) : digits(value);
}

}  // namespace

Json steps_json(const std::vector<StepRecord>& steps) {
  Json out = Json::object();
  for (const char* name : {"solver_ms", "plugin_ms", "objective", "cost", "landmarks", "flips",
                           "rounds", "relinearized"}) {
    out[name] = Json::array();
  }
  for (const StepRecord& step : steps) {
    out["solver_ms"].push_back(digits(1e3 * step.seconds));
    out["plugin_ms"].push_back(digits(step.plugin_ms));
    out["objective"].push_back(decimals(step.objective_after, 3));
    out["cost"].push_back(decimals(step.cost, 3));
    out["landmarks"].push_back(step.landmarks);
    out["flips"].push_back(step.flips);
    out["rounds"].push_back(step.rounds);
    out["relinearized"].push_back(step.relinearized);
  }
  return out;
}

Json graph_report_json(const GraphReport& report, const Json& summary) {
  Json edges = {{"i", Json::array()}, {"j", Json::array()}};
  for (const auto& [from, to] : report.edges) {
    edges["i"].push_back(from);
    edges["j"].push_back(to);
  }
  return {{"schema", 1},
          {"kind", "graph"},
          {"title", report.title},
          {"dimension", report.is_3d ? 3 : 2},
          {"ids", report.ids},
          {"before", coordinates(report.before, report.is_3d)},
          {"after", coordinates(report.after, report.is_3d)},
          {"truth", coordinates(report.truth, report.is_3d)},
          {"landmarks", coordinates(report.landmarks, report.is_3d)},
          {"edges", edges},
          {"closures", closures_json(report.closures)},
          {"objectives", digits(report.objectives)},
          {"steps", steps_json(report.steps)},
          {"summary", summary}};
}

Json trials_report_json(const std::string& title, const std::vector<std::string>& columns,
                        const std::vector<std::vector<std::string>>& rows, const Json& summary) {
  Json table = Json::array();
  for (const std::vector<std::string>& row : rows) {
    Json line = Json::array();
    for (const std::string& text : row) line.push_back(value_json(text));
    table.push_back(std::move(line));
  }
  return {{"schema", 1},        {"kind", "trials"}, {"title", title},
          {"columns", columns}, {"rows", table},    {"summary", summary}};
}

}  // namespace hybrid
