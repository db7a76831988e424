// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/vote/raster_points.h"

#include "base/simd.h"
#include "part/outline_view.h"

#include <algorithm>
#include <array>
#include <limits>

namespace planar_bin_picking {
namespace {

constexpr int kLanes = RasterPoints::kLanes;

/// A linear map in plain numbers.
struct Linear {
  double xx, xy, yx, yy;
  explicit Linear(const Eigen::Matrix2d& m) : xx(m(0, 0)), xy(m(0, 1)), yx(m(1, 0)), yy(m(1, 1)) {}
};

/// The same of VotePlanes.
struct Steps {
  int plane, pitch, pad;
};

/// Extremes by lane.
struct Extremes {
  std::array<double, kLanes> x0, y0, x1, y1;
};

}  // namespace

RasterPoints::RasterPoints(const PartModel& part, int wanted) {
  constexpr int kStride = 37;  // spreads them so that the first few already stand for the whole
  if (wanted % kStride == 0) --wanted;
  const std::vector<int> indices = shapeIndices(part, wanted);
  count = static_cast<int>(indices.size());
  for (int i = 0; i < (count + kLanes - 1) / kLanes * kLanes; ++i) {
    const OutlinePoint& p = part.outline()[indices[std::min(i, count - 1) * kStride % count]];
    const Eigen::Vector2d position = p.position - part.center();
    x.push_back(position.x());
    y.push_back(position.y());
    nx.push_back(p.normal.x());
    ny.push_back(p.normal.y());
  }
}

/// The next whole number below, without a branch.
static PBP_INLINE int floorOf(double value) {
  const int toward_zero = static_cast<int>(value);
  return toward_zero - (static_cast<double>(toward_zero) > value ? 1 : 0);
}

/// kLanes points from the first on.
PBP_SIMD
static void place(const double* x, const double* y, const double* nx, const double* ny,
                  const Linear& to_half_at, const Linear& to_normal_at, const Steps& steps_at,
                  std::int32_t* cells, Extremes* extremes) {
  const Linear to_half = to_half_at, to_normal = to_normal_at;  // no store below can change these
  const Steps steps = steps_at;
  std::array<double, kLanes> qx, qy;
  std::array<int, kLanes> direction;
  for (int k = 0; k < kLanes; ++k) {
    qx[k] = to_half.xx * x[k] + to_half.xy * y[k];
    qy[k] = to_half.yx * x[k] + to_half.yy * y[k];
  }
  for (int k = 0; k < kLanes; ++k) {
    const double u = to_normal.xx * nx[k] + to_normal.xy * ny[k];
    const double v = to_normal.yx * nx[k] + to_normal.yy * ny[k];
    direction[k] = directionBin(u, v);
  }
  for (int k = 0; k < kLanes; ++k) {
    const int hx = floorOf(qx[k] + 0.5), hy = floorOf(qy[k] + 0.5);
    const int phase = (hy & 1) * 2 + (hx & 1);
    cells[k] = (direction[k] * 4 + phase) * steps.plane + ((hy >> 1) + steps.pad) * steps.pitch +
               (hx >> 1) + steps.pad;
  }
  Extremes e = *extremes;
  for (int k = 0; k < kLanes; ++k) {
    e.x0[k] = qx[k] < e.x0[k] ? qx[k] : e.x0[k];
    e.y0[k] = qy[k] < e.y0[k] ? qy[k] : e.y0[k];
    e.x1[k] = qx[k] > e.x1[k] ? qx[k] : e.x1[k];
    e.y1[k] = qy[k] > e.y1[k] ? qy[k] : e.y1[k];
  }
  *extremes = e;
}

Eigen::AlignedBox2d placePoints(const RasterPoints& points, const Eigen::Matrix2d& to_half,
                                const Eigen::Matrix2d& to_normal, const VotePlanes& planes,
                                std::int32_t* cells) {
  constexpr double kFar = std::numeric_limits<double>::max();
  const Steps steps{static_cast<int>(planes.plane), planes.pitch, planes.pad};
  Extremes extremes;
  extremes.x0.fill(kFar);
  extremes.y0.fill(kFar);
  extremes.x1.fill(-kFar);
  extremes.y1.fill(-kFar);
  std::array<std::int32_t, kLanes> block;
  for (int i = 0; i < points.count; i += kLanes) {
    place(&points.x[i], &points.y[i], &points.nx[i], &points.ny[i], Linear(to_half),
          Linear(to_normal), steps, block.data(), &extremes);
    std::copy_n(block.begin(), std::min(kLanes, points.count - i), cells + i);
  }
  const auto least = [](const auto& of) { return *std::min_element(of.begin(), of.end()); };
  const auto most = [](const auto& of) { return *std::max_element(of.begin(), of.end()); };
  return {Eigen::Vector2d(least(extremes.x0), least(extremes.y0)),
          Eigen::Vector2d(most(extremes.x1), most(extremes.y1))};
}

}  // namespace planar_bin_picking
