// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>

#include <Eigen/Core>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "apps/exit_code.h"
#include "apps/hybrid-switching/labelled_table.h"
#include "apps/hybrid-switching/reports.h"
#include "apps/program.h"
#include "mrpt_plugins/bridge/output_directory.h"
#include "mrpt_plugins/output/mode_image.h"

namespace hybrid {
namespace {

using Json = nlohmann::ordered_json;

/// Names count from the least label.
std::vector<std::string> mode_names(const Options& options, const LabelledTable& table) {
  std::vector<std::string> names;
  for (int value : table.label_values) {
    const auto place = static_cast<std::size_t>(value - table.label_values.front());
    names.push_back(place < options.names.size() ? options.names[place]
                                                 : fmt::format("mode {}", value));
  }
  return names;
}

Json rows(const Eigen::MatrixXd& m) {
  Json out = Json::array();
  for (int i = 0; i < m.rows(); ++i) {
    out.push_back(Json::array());
    for (int j = 0; j < m.cols(); ++j) out.back().push_back(m(i, j));
  }
  return out;
}

Json to_json(const SwitchingModel& model) {
  Json out = {{"order", model.order}, {"transition", rows(model.chain.transition)}};
  for (const Autoregression& motion : model.motions) {
    out["motions"].push_back(
        {{"coefficients", rows(motion.coefficients)}, {"covariance", rows(motion.covariance)}});
  }
  return out;
}

/// Number of frames by label (row) and estimated mode (column), labels ascending.
Eigen::MatrixXd confusion(const LabelledTable& table, const FoldedLabels& found) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(table.modes(), table.modes());
  for (int t = 0; t < table.size(); ++t) out(table.labels[t], found.modes[t]) += 1;
  return out;
}

std::string labels_csv(const LabelledTable& table, const FoldedLabels& found) {
  std::string text = "row,fold,label,mode";
  for (int value : table.label_values) text += fmt::format(",p{}", value);
  text += '\n';
  for (int t = 0; t < table.size(); ++t) {
    text += fmt::format("{},{},{},{}", t, found.folds[t], table.label_values[table.labels[t]],
                        table.label_values[found.modes[t]]);
    for (int m = 0; m < table.modes(); ++m)
      text += fmt::format(",{:.6g}", found.probabilities(m, t));
    text += '\n';
  }
  return text;
}

Image timeline(const Options& options, const LabelledTable& table, const FoldedLabels& found,
               double accuracy) {
  ModeTimeline t;
  t.title = "Modes of " + std::filesystem::path(options.input).filename().string();
  t.subtitle = fmt::format(
      "{:.1f} % of {} instants labelled right; each of {} folds (dashed) with a model learnt from "
      "the others{}",
      100 * accuracy, table.size(), options.folds,
      options.without_labels ? ", without their labels" : "");
  t.x_label = "instant";
  t.y_label = options.angle_columns.empty()
                  ? fmt::format("column {}", options.value_columns[0])
                  : fmt::format("change of column {} (rad per instant)", options.angle_columns[0]);
  t.mode_names = mode_names(options, table);
  const Series series = series_of(table, 0, table.size(), options);
  for (int i = 0; i < table.size(); ++i) {
    t.x.push_back(i);
    t.curve.push_back(series(0, i));
  }
  t.strips = {{"labels", table.labels}, {"found", found.modes}};
  t.folds = found.folds;
  return mode_timeline_image(t);
}

Image path(const Options& options, const LabelledTable& table, const FoldedLabels& found) {
  ModePath p;
  p.title = "Path in the colours of the modes found";
  p.subtitle = std::filesystem::path(options.input).filename().string();
  p.x_label = fmt::format("column {}", options.path_columns[0]);
  p.y_label = fmt::format("column {}", options.path_columns[1]);
  p.mode_names = mode_names(options, table);
  for (int i = 0; i < table.size(); ++i) {
    p.points.emplace_back(table.at(i, options.path_columns[0]),
                          table.at(i, options.path_columns[1]));
  }
  p.modes = found.modes;
  return mode_path_image(p);
}

}  // namespace

int report_series(const Options& options) {
  const LabelledTable table = read_table(options.input, options);
  const FoldedLabels found = about({options.input}, [&] { return label_folds(table, options); });
  const Eigen::MatrixXd counts = confusion(table, found);
  const double accuracy = counts.diagonal().sum() / table.size();
  OutputDirectory out(options.output);
  out.write("labels.csv", labels_csv(table, found));
  if (options.pictures) {
    out.write("modes.png", png(timeline(options, table, found, accuracy)));
    out.write("path.png", png(path(options, table, found)));
  }
  Provenance provenance = options.provenance;
  provenance.add_input(options.input);
  warn_of_inputs(provenance);
  Json summary = summary_start("ok", "", provenance);
  summary["method"] = options.without_labels ? "expectation-maximisation" : "labels";
  summary["instants"] = table.size();
  summary["modes"] = table.modes();
  summary["labels"] = table.label_values;
  summary["accuracy"] = accuracy;
  summary["fold_accuracy"] = found.accuracies;
  summary["confusion"] = rows(counts);
  for (const SwitchingModel& model : found.models) summary["models"].push_back(to_json(model));
  const std::vector<std::string> told = out.publish(std::move(summary));
  const int code = settle(kExitOk);
  for (const std::string& text : told) complain("hybrid-switching: {}\n", text);
  say("{} instants, {} modes, {:.1f} % labelled right -> {}\n", table.size(), table.modes(),
      100 * accuracy, options.output);
  return code;
}

}  // namespace hybrid
