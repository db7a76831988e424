// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/part/part_model.h"

#include "part/near_symmetry.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

constexpr double kSamples =
    512.0;  // along the whole outline: a sample every 1 to 2 mm ([1] Sec. II-B)
constexpr int kMinSamplesPerLoop = 12;

/// Samples at the middle of `count` equal pieces of the loop.
void sampleLoop(const Loop& loop, int index, double spacing, std::vector<OutlinePoint>* out) {
  const double length = lengthOf(loop);
  const int count = std::max(kMinSamplesPerLoop, static_cast<int>(std::lround(length / spacing)));
  const double step = length / count;
  double next = 0.5 * step, walked = 0.0;
  const std::size_t n = loop.points.size();
  for (std::size_t i = 0; i + (loop.closed ? 0 : 1) < n; ++i) {
    const Eigen::Vector2d a = loop.points[i], d = loop.points[(i + 1) % n] - a;
    const double piece = d.norm();
    if (piece <= 0.0) continue;
    for (; next <= walked + piece && next < length; next += step) {
      out->push_back({a + d * ((next - walked) / piece), Eigen::Vector2d(d.y(), -d.x()) / piece,
                      index, loop.kind});
    }
    walked += piece;
  }
}

PartFile checked(PartFile file) {
  const auto& loops = file.drawing.loops;
  if (loops.empty() || loops.front().kind != LoopKind::kOuter) {
    throw std::invalid_argument("part " + file.name + ": the outline has no outer contour");
  }
  Eigen::AlignedBox2d box;
  for (const auto& p : loops.front().points) box.extend(p);
  if (box.isEmpty() || !(box.sizes().maxCoeff() > 0.0))
    throw std::invalid_argument("part " + file.name + ": the outer contour has no extent");
  if (!(file.thickness >= 0.0)) {
    throw std::invalid_argument("part " + file.name + ": thickness " +
                                std::to_string(file.thickness) + " m; it must be 0 or more");
  }
  return file;
}

}  // namespace

PartModel::PartModel(PartFile file) : file_(checked(std::move(file))), face_grid_(file_.drawing) {
  const auto& loops = file_.drawing.loops;
  symmetry_ = findSymmetry(file_.drawing);
  pick_poses_ = withSymmetricCopies(file_.pick_poses, symmetry_, file_.thickness);
  Eigen::AlignedBox2d box;
  for (const auto& p : loops.front().points) box.extend(p);
  center_ = box.center();
  double length = 0.0;
  for (const auto& loop : loops) {
    has_print_ = has_print_ || loop.kind == LoopKind::kPrint;
    if (loop.kind != LoopKind::kPrint) length += lengthOf(loop);
  }
  for (const auto& p : loops.front().points) radius_ = std::max(radius_, (p - center_).norm());
  for (std::size_t i = 0; i < loops.size(); ++i) {
    sampleLoop(loops[i], static_cast<int>(i), length / kSamples, &outline_);
  }
  near_symmetries_ = findNearSymmetries(*this);
  near_order_ = findNearOrder(*this);
}

}  // namespace planar_bin_picking
