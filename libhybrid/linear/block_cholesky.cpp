// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/block_cholesky.h"

#include <algorithm>
#include <climits>
#include <cmath>
#include <map>

#include "libhybrid/core/paced_task.h"
#include "libhybrid/linear/kernels/kernels.h"

namespace hybrid {
namespace {

/// The tree is split until no independent subtree has more than this share of the work.
constexpr double kLargestTaskShare = 1.0 / 6.0;
/// Below this many operations threads cost more time than they save.
constexpr double kParallelFlops = 3e6;
constexpr int kStripColumns = 32;

double front_flops(const BlockCholesky::Supernode& s) {
  return double(s.columns) * s.height * s.height;
}

/// First-fit allocation in one growing array.
class Arena {
 public:
  std::size_t take(std::size_t size) {
    for (auto hole = holes_.begin(); hole != holes_.end(); ++hole) {
      if (hole->second < size) continue;
      const std::size_t place = hole->first;
      if (hole->second > size) holes_.emplace(place + size, hole->second - size);
      holes_.erase(hole);
      return place;
    }
    const std::size_t place = end_;
    end_ += size;
    return place;
  }
  void give(std::size_t place, std::size_t size) {
    if (size == 0) return;
    auto hole = holes_.emplace(place, size).first;
    const auto next = std::next(hole);
    if (next != holes_.end() && place + size == next->first) {
      hole->second += next->second;
      holes_.erase(next);
    }
    if (hole == holes_.begin()) return;
    const auto before = std::prev(hole);
    if (before->first + before->second == place) {
      before->second += hole->second;
      holes_.erase(hole);
    }
  }
  std::size_t end() const { return end_; }

 private:
  std::map<std::size_t, std::size_t> holes_;
  std::size_t end_ = 0;
};

std::size_t update_size(const BlockCholesky::Supernode& s) {
  const std::size_t n = round_up(s.below());
  return n * n;
}

}  // namespace

BlockCholesky::BlockCholesky(const BlockMatrix& matrix, const BlockOrdering& ordering)
    : size_(matrix.scalars()), inverse_diagonal_(matrix.scalars()) {
  build_supernodes(matrix, ordering);
  link_children();
  place_blocks(matrix);
  split_into_tasks();
}

void BlockCholesky::build_supernodes(const BlockMatrix& matrix, const BlockOrdering& ordering) {
  const int count = static_cast<int>(ordering.supernodes.size()) - 1;
  supernodes_.resize(std::max(count, 0));
  supernode_of_.resize(size_);
  block_columns_ = ordering.supernodes;
  std::size_t panel = 0;
  for (int s = 0; s < count; ++s) {
    Supernode& node = supernodes_[s];
    node.row_begin = static_cast<int>(rows_.size());
    for (int i = ordering.row_starts[s]; i < ordering.row_starts[s + 1]; ++i) {
      const int position = ordering.rows[i];
      for (int k = 0; k < matrix.dim(position); ++k) rows_.push_back(matrix.start(position) + k);
    }
    node.height = static_cast<int>(rows_.size()) - node.row_begin;
    node.first = matrix.start(ordering.supernodes[s]);
    node.columns = matrix.start(ordering.supernodes[s + 1]) - node.first;
    node.stride = node.height + kRowPadding;
    node.panel = panel;
    panel += std::size_t(node.stride) * node.columns + kPacket;
    std::fill_n(supernode_of_.begin() + node.first, node.columns, s);
  }
  panels_.assign(panel, 0.0);
}

void BlockCholesky::link_children() {
  std::vector<int> place(size_);
  std::vector<std::vector<int>> children(supernodes_.size());
  for (int s = 0; s < supernode_count(); ++s) {
    Supernode& node = supernodes_[s];
    if (node.below() == 0) continue;
    node.parent = supernode_of_[rows(node)[node.columns]];
    children[node.parent].push_back(s);
  }
  for (int p = 0; p < supernode_count(); ++p) {
    Supernode& parent = supernodes_[p];
    for (int i = 0; i < parent.height; ++i) place[rows(parent)[i]] = i;
    parent.child_begin = static_cast<int>(children_.size());
    for (int s : children[p]) {
      Supernode& node = supernodes_[s];
      children_.push_back(s);
      node.run_begin = static_cast<int>(runs_.size());
      for (int i = 0; i < node.below(); ++i) {
        const int to = place[rows(node)[node.columns + i]];
        const bool fresh = static_cast<int>(runs_.size()) == node.run_begin;
        // A run does not cross the border between the parent's panel and its update.
        if (fresh || runs_.back().to + runs_.back().length != to || to == parent.columns) {
          runs_.push_back({i, to, 0});
        }
        ++runs_.back().length;
      }
      node.run_end = static_cast<int>(runs_.size());
    }
    parent.child_end = static_cast<int>(children_.size());
  }
}

void BlockCholesky::place_blocks(const BlockMatrix& matrix) {
  block_places_.resize(matrix.block_count());
  std::vector<int> place(size_);
  for (int s = 0; s < supernode_count(); ++s) {
    const Supernode& node = supernodes_[s];
    for (int i = 0; i < node.height; ++i) place[rows(node)[i]] = i;
    for (int b = matrix.block_begin(block_columns_[s]);
         b < matrix.block_begin(block_columns_[s + 1]); ++b) {
      const BlockMatrix::Block& block = matrix.block(b);
      block_places_[b] = node.panel + place[matrix.start(block.row)] +
                         std::size_t(matrix.start(block.col) - node.first) * node.stride;
    }
  }
}

void BlockCholesky::split_into_tasks() {
  const int n = supernode_count();
  std::vector<double> work(n, 0.0);
  std::vector<int> subtree(n, 1);
  double total = 0.0;
  for (int s = 0; s < n; ++s) {
    work[s] += front_flops(supernodes_[s]);
    total += front_flops(supernodes_[s]);
    if (supernodes_[s].parent < 0) continue;
    work[supernodes_[s].parent] += work[s];
    subtree[supernodes_[s].parent] += subtree[s];
  }
  std::size_t used = 0;
  if (total >= kParallelFlops) {
    // In a postorder the subtree of s is s - subtree[s] + 1 .. s. The largest subtrees within the
    // limit become tasks.
    for (int s = n - 1; s >= 0;) {
      if (work[s] > kLargestTaskShare * total) {
        top_.push_back(s--);
        continue;
      }
      tasks_.emplace_back();
      for (int i = s - subtree[s] + 1; i <= s; ++i) tasks_.back().push_back(i);
      s -= subtree[s];
    }
    std::reverse(top_.begin(), top_.end());
    std::sort(tasks_.begin(), tasks_.end(),
              [&](const auto& a, const auto& b) { return work[a.back()] > work[b.back()]; });
  } else {
    for (int s = 0; s < n; ++s) top_.push_back(s);
  }
  for (const std::vector<int>& task : tasks_) used = plan_updates(task, used);
  used = plan_updates(top_, used);
  workspace_.assign(used, 0.0);
}

std::size_t BlockCholesky::plan_updates(const std::vector<int>& list, std::size_t base) {
  Arena arena;
  std::vector<bool> here(supernodes_.size(), false);
  for (int s : list) {
    Supernode& node = supernodes_[s];
    here[s] = true;
    node.update = base + arena.take(update_size(node));
    for (int c = node.child_begin; c < node.child_end; ++c) {
      const Supernode& child = supernodes_[children_[c]];
      if (here[children_[c]]) arena.give(child.update - base, update_size(child));
    }
  }
  return base + arena.end();
}

void BlockCholesky::load_panel(int s, const BlockMatrix& matrix, const double* extra) {
  const Supernode& node = supernodes_[s];
  double* panel = panels_.data() + node.panel;
  std::fill_n(panel, std::size_t(node.stride) * node.columns, 0.0);
  for (int col = block_columns_[s]; col < block_columns_[s + 1]; ++col) {
    const int dim = matrix.dim(col);
    const int stride = matrix.stride(col);
    for (int b = matrix.block_begin(col); b < matrix.block_begin(col + 1); ++b) {
      const double* from = matrix.values().data() + matrix.block(b).offset;
      double* to = panels_.data() + block_places_[b];
      const int height = matrix.dim(matrix.block(b).row);
      for (int c = 0; c < dim; ++c) {
        for (int r = 0; r < height; ++r) to[c * node.stride + r] = from[c * stride + r];
      }
    }
  }
  for (int c = 0; c < node.columns; ++c) panel[c * (node.stride + 1)] += extra[node.first + c];
}

void BlockCholesky::add_to_panel(const Supernode& child, const Supernode& parent) {
  const int size = round_up(child.below());
  const double* update = workspace_.data() + child.update;
  double* panel = panels_.data() + parent.panel;
  for (int a = child.run_begin; a < child.run_end; ++a) {
    const Run& across = runs_[a];
    if (across.to >= parent.columns) break;
    for (int k = 0; k < across.length; ++k) {
      const double* from = update + std::size_t(across.from + k) * size;
      double* to = panel + std::size_t(across.to + k) * parent.stride;
      for (int r = k; r < across.length; ++r) to[across.to + r] += from[across.from + r];
      for (int d = a + 1; d < child.run_end; ++d) {
        const Run& down = runs_[d];
        for (int r = 0; r < down.length; ++r) to[down.to + r] += from[down.from + r];
      }
    }
  }
}

void BlockCholesky::add_to_update(const Supernode& child, const Supernode& parent) {
  const int size = round_up(child.below());
  const int parent_size = round_up(parent.below());
  const double* update = workspace_.data() + child.update;
  double* target = workspace_.data() + parent.update;
  for (int a = child.run_begin; a < child.run_end; ++a) {
    const Run& across = runs_[a];
    if (across.to < parent.columns) continue;
    for (int k = 0; k < across.length; ++k) {
      const double* from = update + std::size_t(across.from + k) * size;
      double* to =
          target + std::size_t(across.to - parent.columns + k) * parent_size - parent.columns;
      for (int r = k; r < across.length; ++r) to[across.to + r] += from[across.from + r];
      for (int d = a + 1; d < child.run_end; ++d) {
        const Run& down = runs_[d];
        for (int r = 0; r < down.length; ++r) to[down.to + r] += from[down.from + r];
      }
    }
  }
}

int BlockCholesky::process(int s, const BlockMatrix& matrix, const double* extra,
                           WorkerPool* pool) {
  const Supernode& node = supernodes_[s];
  load_panel(s, matrix, extra);
  for (int c = node.child_begin; c < node.child_end; ++c) {
    add_to_panel(supernodes_[children_[c]], node);
  }
  double* panel = panels_.data() + node.panel;
  const int failed = kernels().factorize_panel(panel, node.stride, node.height, node.columns);
  for (int c = 0; c < node.columns; ++c) {
    inverse_diagonal_[node.first + c] = 1.0 / panel[std::size_t(c) * (node.stride + 1)];
  }
  if (node.below() > 0) {
    double* update = workspace_.data() + node.update;
    const int size = round_up(node.below());
    if (pool != nullptr && front_flops(node) > kParallelFlops) {
      pool->run((size + kStripColumns - 1) / kStripColumns, [&](int strip) {
        const int end = std::min(size, (strip + 1) * kStripColumns);
        kernels().update_columns(panel, node.stride, node.columns, update, size,
                                 strip * kStripColumns, end);
      });
    } else {
      kernels().update_columns(panel, node.stride, node.columns, update, size, 0, size);
    }
    for (int c = node.child_begin; c < node.child_end; ++c) {
      add_to_update(supernodes_[children_[c]], node);
    }
  }
  return failed < 0 ? INT_MAX : node.first + failed;
}

int BlockCholesky::factorize(const BlockMatrix& matrix, const double* extra, WorkerPool& pool) {
  std::vector<int> failed(tasks_.size() + 1, INT_MAX);
  pool.run(static_cast<int>(tasks_.size()), [&](int t) {
    for (int s : tasks_[t]) failed[t] = std::min(failed[t], process(s, matrix, extra, nullptr));
  });
  for (const std::vector<int>& task : tasks_) {
    for (int s : task) note_work(front_flops(supernodes_[s]));
  }
  for (int s : top_) {
    failed.back() = std::min(failed.back(), process(s, matrix, extra, &pool));
    note_work(front_flops(supernodes_[s]));
  }
  const int first = *std::min_element(failed.begin(), failed.end());
  return first == INT_MAX ? -1 : first;
}

void BlockCholesky::solve_lower(double* x) const {
  std::vector<double> buffer;
  for (const Supernode& node : supernodes_) {
    buffer.assign(node.stride, 0.0);
    std::copy_n(x + node.first, node.columns, buffer.begin());
    kernels().forward(panel(node), node.stride, node.height, node.columns,
                      inverse_diagonal_.data() + node.first, buffer.data());
    std::copy_n(buffer.begin(), node.columns, x + node.first);
    const int* row = rows(node);
    for (int r = node.columns; r < node.height; ++r) x[row[r]] += buffer[r];
  }
}

void BlockCholesky::solve_upper(double* x) const {
  std::vector<double> buffer;
  for (auto node = supernodes_.rbegin(); node != supernodes_.rend(); ++node) {
    const int* row = rows(*node);
    buffer.assign(node->stride, 0.0);
    for (int r = 0; r < node->height; ++r) buffer[r] = x[row[r]];
    kernels().backward(panel(*node), node->stride, node->height, node->columns,
                       inverse_diagonal_.data() + node->first, buffer.data());
    std::copy_n(buffer.begin(), node->columns, x + node->first);
  }
}

void BlockCholesky::solve(double* x) const {
  solve_lower(x);
  solve_upper(x);
}

}  // namespace hybrid
