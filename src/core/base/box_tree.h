// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Finds the boxes that meet a box without looking at all of them.

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <stdexcept>
#include <vector>

namespace planar_bin_picking {

/// A binary tree over boxes, halved at the median of their centers along the longer side.
/// Cost: O(n log n) to build, near O(log n) for a query that meets little. Many long lines that lie
/// aslant over each other all meet with their boxes; a part has no such crowd, and it is refused.
class BoxTree {
 public:
  explicit BoxTree(std::vector<Eigen::AlignedBox2d> boxes)
      : boxes_(std::move(boxes)), order_(boxes_.size()) {
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    if (!order_.empty()) {
      nodes_.resize(nodeCount(order_.size()));
      build(0, 0, order_.size());
    }
  }

  /// Calls visit(index) for each box that meets the given one, in an order that depends on the
  /// boxes alone, until it returns true.
  /// @return  whether it did
  /// @throws std::runtime_error  all queries together met more boxes than can be looked at
  template <class Visit>
  bool any(const Eigen::AlignedBox2d& box, const Visit& visit) const {
    return !order_.empty() && anyBelow(0, 0, order_.size(), box, visit);
  }

 private:
  static constexpr std::size_t kLeaf = 4;
  static constexpr std::size_t kVisitsMax = 8000000;  // about half a second

  /// Children of node k are 2 k + 1 and 2 k + 2.
  static std::size_t nodeCount(std::size_t boxes) {
    std::size_t count = 1;
    for (std::size_t level = 1, most = boxes; most > kLeaf; most = (most + 1) / 2) {
      level *= 2;
      count += level;
    }
    return count;
  }

  void build(std::size_t node, std::size_t begin, std::size_t end) {
    Eigen::AlignedBox2d all, centers;
    for (std::size_t i = begin; i < end; ++i) {
      all.extend(boxes_[order_[i]]);
      centers.extend(boxes_[order_[i]].center());
    }
    nodes_[node] = all;
    if (end - begin <= kLeaf) return;
    const int axis = centers.sizes().x() >= centers.sizes().y() ? 0 : 1;
    const std::size_t middle = begin + (end - begin + 1) / 2;
    const auto at = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end), [&](std::size_t a, std::size_t b) {
      const double x = boxes_[a].center()[axis], y = boxes_[b].center()[axis];
      return x != y ? x < y : a < b;
    });
    build(2 * node + 1, begin, middle);
    build(2 * node + 2, middle, end);
  }

  template <class Visit>
  bool anyBelow(std::size_t node, std::size_t begin, std::size_t end,
                const Eigen::AlignedBox2d& box, const Visit& visit) const {
    if (!nodes_[node].intersects(box)) return false;
    if (end - begin <= kLeaf) {
      for (std::size_t i = begin; i < end; ++i) {
        if (!boxes_[order_[i]].intersects(box)) continue;
        if (++visits_ > kVisitsMax)
          throw std::runtime_error("has too many lines too close together to be a single part");
        if (visit(order_[i])) return true;
      }
      return false;
    }
    const std::size_t middle = begin + (end - begin + 1) / 2;
    return anyBelow(2 * node + 1, begin, middle, box, visit) ||
           anyBelow(2 * node + 2, middle, end, box, visit);
  }

  std::vector<Eigen::AlignedBox2d> boxes_;
  std::vector<std::size_t> order_;
  std::vector<Eigen::AlignedBox2d> nodes_;
  mutable std::size_t visits_ = 0;
};

}  // namespace planar_bin_picking
