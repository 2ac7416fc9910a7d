// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/sparsity.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "libhybrid/core/error.h"
#include "libhybrid/core/key_letters.h"
#include "mrpt_plugins/drawing/matrix_image.h"

namespace hybrid {
namespace {

constexpr Color kBlocks = palette::kEstimate;
constexpr Color kFill{230, 120, 0};
constexpr Color kOld{165, 165, 165};
constexpr double kMostBlocks = 3e7;  // of a picture; more would take gigabytes of memory

double percent(std::size_t part, double whole) {
  return 100.0 * static_cast<double>(part) / whole;
}

/// Column order for readers: poses in the order of time, then the other variables.
std::vector<int> reading_order(const JacobianPattern& jacobian) {
  std::vector<int> order(jacobian.variables.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_partition(order.begin(), order.end(),
                        [&](int v) { return jacobian.variables[v].letter() == key_letter::kPose; });
  return order;
}

/// The pattern with its variables permuted: column k is column order[k] of the given one.
JacobianPattern reordered(const JacobianPattern& jacobian, const std::vector<int>& order) {
  JacobianPattern result;
  std::vector<int> column(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    column[order[k]] = static_cast<int>(k);
    result.variables.push_back(jacobian.variables[order[k]]);
    result.dims.push_back(jacobian.dims[order[k]]);
  }
  for (const auto& factor : jacobian.factors) {
    std::vector<int>& row = result.factors.emplace_back();
    for (int v : factor) row.push_back(column[v]);
  }
  return result;
}

Blocks mirrored(const Blocks& triangle) {
  Blocks all = triangle;
  for (const auto& [row, column] : triangle) {
    if (row != column) all.emplace_back(column, row);
  }
  return all;
}

Blocks whole_matrix(const BlockPattern& pattern) {
  Blocks triangle = pattern.edges;
  for (int b = 0; b < pattern.size(); ++b) triangle.emplace_back(b, b);
  return mirrored(triangle);
}

std::string variables_text(const JacobianPattern& jacobian) {
  const auto poses = std::count_if(jacobian.variables.begin(), jacobian.variables.end(),
                                   [](Key key) { return key.letter() == key_letter::kPose; });
  const std::size_t others = jacobian.variables.size() - poses;
  if (others == 0) return fmt::format("{} poses", poses);
  return fmt::format("{} poses, then {} landmarks and others", poses, others);
}

Image jacobian_picture(const JacobianPattern& jacobian, const std::string& title) {
  const int rows = static_cast<int>(jacobian.factors.size());
  const int columns = static_cast<int>(jacobian.variables.size());
  const Blocks blocks = jacobian_blocks(jacobian);
  MatrixPanel panel{
      fmt::format("{} x {} blocks", rows, columns), rows, columns, "factor", "variable", {}};
  panel.layers.push_back({fmt::format("{} blocks ({:.3g} %)", blocks.size(),
                                      percent(blocks.size(), double(rows) * columns)),
                          kBlocks, blocks});
  return matrix_image("Jacobian of " + title,
                      fmt::format("Rows: {} factors. Columns: {}.", rows, variables_text(jacobian)),
                      {panel});
}

MatrixPanel square(const std::string& heading, std::size_t size, const std::string& label) {
  const int n = static_cast<int>(size);
  return {fmt::format("{}: {} x {} blocks", heading, n, n), n, n, label, label, {}};
}

Image information_picture(const JacobianPattern& jacobian, const BlockPattern& information,
                          const std::string& title) {
  const Blocks blocks = whole_matrix(information);
  const double n = information.size();
  MatrixPanel panel = square("J'J", jacobian.variables.size(), "variable");
  panel.layers.push_back(
      {fmt::format("{} blocks ({:.3g} %)", blocks.size(), percent(blocks.size(), n * n)), kBlocks,
       blocks});
  return matrix_image(
      "Information matrix of " + title,
      fmt::format("Two variables meet where a factor joins them: {}.", variables_text(jacobian)),
      {panel});
}

Image factor_picture(const BlockPattern& information, const std::vector<int>& order,
                     const std::string& title) {
  FilledPattern factor = cholesky_pattern(information, order);
  const double n = information.size();
  const std::size_t total = factor.original.size() + factor.fill.size();
  MatrixPanel panel = square("L", order.size(), "place in the elimination order");
  const std::string subtitle =
      fmt::format("L L' = J'J. L has {} blocks ({:.3g} % of its triangle), {} of them fill-in.",
                  total, percent(total, 0.5 * n * (n + 1)), factor.fill.size());
  panel.layers.push_back({fmt::format("{} blocks that J'J has too", factor.original.size()),
                          kBlocks, std::move(factor.original)});
  panel.layers.push_back(
      {fmt::format("{} blocks of fill-in", factor.fill.size()), kFill, std::move(factor.fill)});
  return matrix_image("Cholesky factor of " + title, subtitle, {panel});
}

/// Marks the older half of the poses, which are the first variables.
std::vector<char> older_half(const JacobianPattern& jacobian) {
  const auto poses = std::count_if(jacobian.variables.begin(), jacobian.variables.end(),
                                   [](Key key) { return key.letter() == key_letter::kPose; });
  std::vector<char> removed(jacobian.variables.size(), 0);
  std::fill(removed.begin(), removed.begin() + poses / 2, 1);
  return removed;
}

Image marginal_picture(const JacobianPattern& jacobian, const BlockPattern& information,
                       const std::string& title) {
  const std::vector<char> removed = older_half(jacobian);
  const auto gone = std::count(removed.begin(), removed.end(), 1);
  MatrixPanel before = square("Before", removed.size(), "variable");
  MatrixLayer old{"", kOld, {}};
  MatrixLayer kept{"", kBlocks, {}};
  for (const auto& block : whole_matrix(information)) {
    const bool goes = removed[block.first] || removed[block.second];
    (goes ? old : kept).entries.push_back(block);
  }
  old.label = fmt::format("{} blocks of the states that go", old.entries.size());
  kept.label = fmt::format("{} blocks between those that stay", kept.entries.size());

  const FilledPattern marginal = marginalized_pattern(information, removed);
  MatrixPanel after = square("After", removed.size() - gone, "variable that stays");
  MatrixLayer fill{"", kFill, mirrored(marginal.fill)};
  MatrixLayer same{"", kBlocks, mirrored(marginal.original)};
  fill.label = fmt::format("{} blocks of fill-in", fill.entries.size());
  same.label = fmt::format("{} blocks that were there", same.entries.size());
  const std::string subtitle = fmt::format(
      "The {} oldest poses leave the information matrix; what they joined is now joined directly. "
      "Fill-in: {} blocks.",
      gone, fill.entries.size());
  before.layers = {std::move(old), std::move(kept)};
  after.layers = {std::move(fill), std::move(same)};
  return matrix_image("Marginalisation in " + title, subtitle, {before, after});
}

}  // namespace

std::vector<std::string> write_sparsity(const OutputDirectory& out, const HybridGraph& graph,
                                        const Assignment& assignment, const std::vector<Key>& order,
                                        const std::string& title) {
  const JacobianPattern sorted = jacobian_pattern(graph, assignment);
  if (sorted.variables.empty()) throw Error("a graph without factors has no structure to draw");
  const BlockPattern sorted_information = information_pattern(sorted);
  std::vector<int> elimination;
  for (Key key : order) {
    if (sorted.contains(key)) elimination.push_back(sorted.index(key));
  }
  if (order.empty()) elimination = order_blocks(sorted_information).order;
  const JacobianPattern jacobian = reordered(sorted, reading_order(sorted));
  const BlockPattern information = information_pattern(jacobian);
  const auto write = [&](const std::string& name, const Image& image) {
    out.write("sparsity_" + name + ".png", png(image));
  };
  write("jacobian", jacobian_picture(jacobian, title));
  write("information", information_picture(jacobian, information, title));
  write("factor", factor_picture(sorted_information, elimination, title));
  double coupled = 0;
  for (const auto& clique : marginal_cliques(information, older_half(jacobian))) {
    coupled += 0.5 * static_cast<double>(clique.size()) * static_cast<double>(clique.size());
  }
  if (coupled > kMostBlocks) {
    return {fmt::format("sparsity_marginalized.png is left out: {:.2g} blocks are too many to draw",
                        coupled)};
  }
  write("marginalized", marginal_picture(jacobian, information, title));
  return {};
}

}  // namespace hybrid
