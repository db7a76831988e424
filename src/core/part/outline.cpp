// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/part/outline.h"

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

/// Along the whole outline: a sample every 1 to 2 mm, as in [1] Sec. II-B.
constexpr double kSamples = 512.0;
constexpr int kMinSamplesPerLoop = 12;  // 30 degrees apart on a small hole

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

}  // namespace

std::vector<OutlinePoint> sampleOutline(const Drawing& drawing) {
  double length = 0.0;
  for (const Loop& loop : drawing.loops) {
    if (loop.kind != LoopKind::kPrint) length += lengthOf(loop);
  }
  std::vector<OutlinePoint> outline;
  for (std::size_t i = 0; i < drawing.loops.size(); ++i) {
    sampleLoop(drawing.loops[i], static_cast<int>(i), length / kSamples, &outline);
  }
  return outline;
}

}  // namespace planar_bin_picking
