// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <unordered_map>
#include <utility>
#include <vector>

#include "libhybrid/core/assignment.h"
#include "libhybrid/discrete/table.h"

namespace HYBRID_API hybrid {

/// The values of least total cost, by elimination of the variables in the order in which they came:
/// min-sum messages, each to the oldest variable that its own depends on, make a tree. Where tables
/// change, only the messages from there to the root are made again, and values below are looked at
/// only where one that they depend on has changed. So a step along a chain costs its newest part.
class DiscreteTree {
 public:
  /// What is asked of the owner of variables and tables.
  struct Source {
    std::function<std::uint64_t(Key)> number;  ///< in the order of arrival
    /// All tables that have the variable.
    std::function<void(Key, std::vector<const Table*>&)> tables;
  };
  struct Result {
    std::vector<std::pair<Key, int>> changed;  ///< variables with their new values
    /// Variables whose messages would be too large. If there are any, nothing was solved: it is to
    /// be asked again without their components.
    std::vector<Key> wide;
    int components = 0;  ///< that were looked at
    int made = 0;        ///< messages
  };

  bool contains(Key key) const { return nodes_.count(key) != 0; }
  /// Tables of a variable have come, gone or changed; nothing where it is not in the tree.
  void touch(Key key) noexcept;
  /// The variable is no more.
  void forget(Key key) noexcept;
  /// With some more variables, and all that share tables with them and are not in the tree yet.
  /// Ties keep the values of `incumbent`, so that costs decrease where a value changes.
  Result solve(const std::vector<Key>& entering, const Source& source, const Assignment& incumbent);
  std::size_t bytes() const;

 private:
  struct Node {
    std::uint64_t number = 0;
    std::vector<DiscreteKey> scope;  // what the message depends on, the oldest first; itself last
    std::vector<double> costs;       // row-major over the scope
    std::vector<Key> children;       // that send it their messages
    bool is_touched = false;
  };
  using Numbered = std::pair<std::uint64_t, Key>;

  std::vector<Key> make_all(const std::vector<Key>& entering, const Source& source,
                            std::vector<Key>& wide);
  static std::vector<const Table*> own_tables(Key key, const Node& node, const Source& source);
  bool set_scope(Key key, Node& node, const std::vector<const Table*>& tables,
                 const Source& source) const;
  bool make(Key key, Node& node, const Source& source) const;
  void attach(Key key, const Node& node, std::set<Numbered>& waiting);
  void detach(Key key, const Node& node) noexcept;
  std::optional<Key> parent_of(const Node& node) const;
  static std::vector<double>::const_iterator costs_given(const Node& node,
                                                         const std::function<int(Key)>& value_of);
  std::map<Key, int> descend(const std::vector<Key>& made, const Assignment& incumbent) const;
  static bool cost_less(const std::map<Key, int>& changed, const Source& source,
                        const Assignment& incumbent);

  std::unordered_map<Key, Node> nodes_;
  std::vector<Key> touched_;  // has room for all nodes
};

}  // namespace hybrid
