// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/judge/explained.h"

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

constexpr float kCellPx = 3.0f;  // an edge lies within its cell or the next one: 3 to 6 pixels off
constexpr int kDirections = 8;
constexpr double kHardlyAny = 0.1;  // share of the outline: chance decides what so few say

int directionOf(const Eigen::Vector2f& normal) {
  const double turns = std::atan2(normal.y(), normal.x()) / (2.0 * M_PI) + 1.0;
  return static_cast<int>(std::floor(turns * kDirections + 0.5)) % kDirections;
}

}  // namespace

ExplainedEdges::ExplainedEdges(const std::vector<const ScoredPose*>& poses) {
  Eigen::Vector2f most = Eigen::Vector2f::Zero();
  for (const ScoredPose* pose : poses)
    for (const OutlineEvidence& point : pose->outline) most = most.cwiseMax(point.pixel);
  cols_ = static_cast<int>(most.x() / kCellPx) + 1;
  rows_ = static_cast<int>(most.y() / kCellPx) + 1;
  directions_.resize(static_cast<std::size_t>(cols_) * rows_);
}

void ExplainedEdges::add(const ScoredPose& pose) {
  for (const OutlineEvidence& point : pose.outline) {
    if (point.pixel.minCoeff() < 0.0f) continue;
    const int col = static_cast<int>(point.pixel.x() / kCellPx);
    const int row = static_cast<int>(point.pixel.y() / kCellPx);
    directions_[static_cast<std::size_t>(row) * cols_ + col] |=
        static_cast<std::uint8_t>(1u << directionOf(point.normal));
  }
}

double ExplainedEdges::ownScore(const ScoredPose& pose) const {
  double all_weights = 0.0, own = 0.0, own_weights = 0.0;
  for (const OutlineEvidence& point : pose.outline) {
    const int col = static_cast<int>(std::floor(point.pixel.x() / kCellPx));
    const int row = static_cast<int>(std::floor(point.pixel.y() / kCellPx));
    // The opposite direction and its two neighbours.
    const int opposite = directionOf(-point.normal);
    unsigned int wanted = 0;
    for (const int d : {kDirections - 1, 0, 1}) wanted |= 1u << ((opposite + d) % kDirections);
    unsigned int there = 0;
    for (int r = std::max(0, row - 1); r <= std::min(rows_ - 1, row + 1); ++r)
      for (int c = std::max(0, col - 1); c <= std::min(cols_ - 1, col + 1); ++c)
        there |= directions_[static_cast<std::size_t>(r) * cols_ + c];
    all_weights += point.weight;
    if ((there & wanted) != 0) continue;
    own += point.weight * point.inlier;
    own_weights += point.weight;
  }
  return own_weights > kHardlyAny * all_weights ? own / own_weights : pose.evidence.edges;
}

}  // namespace planar_bin_picking
