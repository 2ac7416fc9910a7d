// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/report/graph_report.h"

#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "libhybrid/io/parse_number.h"
#include "mrpt_plugins/report/columns.h"
#include "mrpt_plugins/report/detail/closure_columns.h"

namespace hybrid {
namespace {

using Json = nlohmann::ordered_json;

Json closures_json(const std::vector<GraphReport::Closure>& closures) {
  Json out = closure_columns(closures);
  out["history"] = Json::array();
  for (const GraphReport::Closure& closure : closures) {
    Json history = Json::array();
    for (const auto& [pose, status] : closure.decision.history) {
      history.push_back({pose, to_string(status)});
    }
    out["history"].push_back(std::move(history));
  }
  return out;
}

/// A number where the whole text is one.
Json value_json(const std::string& text) {
  double value = 0.0;
  return parse_number(text, value) ? digits(value) : Json(text);
}

}  // namespace

Json steps_json(const std::vector<StepRecord>& steps) {
  Json out = empty_columns({"solver_ms", "plugin_ms", "objective", "cost", "landmarks", "flips",
                            "rounds", "relinearized"});
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
  Json edges = empty_columns({"i", "j"});
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

Json trials_report_json(const std::string& title, const std::string& table, const Json& summary) {
  Json rows = Json::array();
  std::istringstream lines(table);
  for (std::string line; std::getline(lines, line);) {
    Json row = Json::array();
    std::istringstream cells(line + ',');  // getline drops an empty last cell
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(value_json(cell));
    rows.push_back(std::move(row));
  }
  Json columns = rows.empty() ? Json::array() : rows.front();
  if (!rows.empty()) rows.erase(0);
  return {{"schema", 1},        {"kind", "trials"}, {"title", title},
          {"columns", columns}, {"rows", rows},     {"summary", summary}};
}

}  // namespace hybrid
