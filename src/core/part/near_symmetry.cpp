// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/part/near_symmetry.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace planar_bin_picking {
namespace {

constexpr int kAngles = 360;  // steps of one degree: several to the width of a peak
constexpr double kStep = 2.0 * M_PI / kAngles;
/// Of the grid of distances: cells of a quarter tolerance, as many to a side as fit into a cache,
/// over twice the radius either way.
constexpr double kCellsPerTolerance = 4.0, kGridRadii = 2.0;
constexpr int kHalfMost = 256;
/// Of the nearness from one step to the next: a ring with a few small holes looks alike at every
/// turn.
constexpr double kFlat = 0.02;
/// Steps within which a turn counts as one of the symmetries: the peak's error and a half.
constexpr double kExactSteps = 1.5;
/// Radians: as near to the share of a full turn that makes an order.
constexpr double kOrderNear = 0.02;

/// Distance to the outline's nearest sample, on a grid, up to the tolerance.
class NearOutline {
 public:
  NearOutline(const std::vector<Eigen::Vector2d>& points, double tolerance)
      : half_(std::min(kHalfMost, static_cast<int>(kCellsPerTolerance * kGridRadii / tolerance))),
        scale_(half_ / kGridRadii),
        tolerance_(tolerance),
        cells_(4 * static_cast<std::size_t>(half_) * half_, static_cast<float>(tolerance)) {
    const int reach = static_cast<int>(std::ceil(tolerance * scale_));
    for (const auto& p : points) {
      const int x = cell(p.x()), y = cell(p.y());
      for (int j = std::max(0, y - reach); j <= std::min(2 * half_ - 1, y + reach); ++j) {
        for (int i = std::max(0, x - reach); i <= std::min(2 * half_ - 1, x + reach); ++i) {
          const Eigen::Vector2d c(i + 0.5 - half_, j + 0.5 - half_);
          float& distance = cells_[static_cast<std::size_t>(j) * 2 * half_ + i];
          distance = std::min(distance, static_cast<float>((c / scale_ - p).norm()));
        }
      }
    }
  }
  bool operator()(const Eigen::Vector2d& p) const { return distance(p) < tolerance_; }
  /// 1 on the outline, 0 from the tolerance on: unlike a count it has its peak in the right place.
  double nearness(const Eigen::Vector2d& p) const {
    const double off = distance(p) / tolerance_;
    return 1.0 - off * off;
  }

 private:
  int cell(double v) const {
    // Rounded down; the library's floor is a call, and this is most of what a part costs.
    const double scaled = v * scale_;
    const int toward_zero = static_cast<int>(scaled);
    return half_ + toward_zero - (scaled < toward_zero ? 1 : 0);
  }
  bool valid(int c) const { return c >= 0 && c < 2 * half_; }
  double distance(const Eigen::Vector2d& p) const {
    const int x = cell(p.x()), y = cell(p.y());
    return valid(x) && valid(y) ? cells_[static_cast<std::size_t>(y) * 2 * half_ + x] : tolerance_;
  }
  int half_;
  double scale_;  ///< cells to a radius
  double tolerance_;
  std::vector<float> cells_;
};

/// Mirrored about the x axis where it flips, then turned.
Eigen::Matrix2d mapping(bool flip, double angle) {
  return Eigen::Rotation2Dd(angle).toRotationMatrix() *
         Eigen::Vector2d(1.0, flip ? -1.0 : 1.0).asDiagonal();
}

Eigen::Isometry3d turned(const OutlineShape& part, bool flip, double angle) {
  const Eigen::Vector2d& c = part.symmetry.center;
  const Eigen::Translation3d centre(c.x(), c.y(), -0.5 * part.thickness);
  // A turn by pi about the in-plane axis at angle / 2 mirrors the outline about that axis.
  const Eigen::AngleAxisd turn =
      flip ? Eigen::AngleAxisd(M_PI, Eigen::Vector3d(std::cos(angle / 2), std::sin(angle / 2), 0))
           : Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ());
  return Eigen::Isometry3d(centre * turn * centre.inverse());
}

/// A turn after which much of the shape lies on itself.
struct Turn {
  double share, angle;
  bool flip;
};

/// Turns at the peaks of nearness; where it is flat, all of them.
std::vector<Turn> findTurns(const std::vector<Eigen::Vector2d>& shape, const NearOutline& near,
                            const Symmetry& symmetry, double share_min) {
  const auto mean = [&](bool flip, double angle, auto&& of) {
    const Eigen::Matrix2d map = mapping(flip, angle);
    double sum = 0.0;
    for (const auto& p : shape) sum += of(map * p);
    return sum / static_cast<double>(shape.size());
  };
  std::vector<Turn> found;
  // Turns that differ by a symmetry of the shape are the same, and so are the two faces of a shape
  // that equals its mirror image.
  const int order = std::max(1, symmetry.order);
  for (const bool flip : {false, true}) {
    if (flip && symmetry.mirror) break;
    const auto nearness = [&](int k) {
      return mean(flip, kStep * k, [&](const auto& p) { return near.nearness(p); });
    };
    double before = 0.0, here = nearness(flip ? kAngles - 1 : 0), after = nearness(flip ? 0 : 1);
    for (int k = flip ? 0 : 1; k * order < kAngles; ++k) {
      before = std::exchange(here, std::exchange(after, nearness((k + 1) % kAngles)));
      double angle = kStep * k;
      if (here >= before && here > after) {
        angle += kStep * 0.5 * (before - after) / (before - 2.0 * here + after);
      } else if (std::max(std::abs(here - before), std::abs(here - after)) > kFlat) {
        continue;
      }
      const double share = mean(flip, angle, near);
      if (share >= share_min) found.push_back({share, angle, flip});
    }
  }
  return found;
}

bool isExact(const Turn& turn, const Symmetry& symmetry) {
  if (turn.flip && !symmetry.mirror) return false;
  if (symmetry.order == 0) return true;
  const double base = turn.flip ? 2.0 * symmetry.mirror_axis : 0.0;
  const double turns = (turn.angle - base) * symmetry.order / (2.0 * M_PI);
  return std::abs(turns - std::round(turns)) * 2.0 * M_PI / symmetry.order < kExactSteps * kStep;
}

}  // namespace

std::vector<NearSymmetry> findNearSymmetries(const OutlineShape& part, double tolerance,
                                             double share_min) {
  const Symmetry& symmetry = part.symmetry;
  std::vector<Eigen::Vector2d> shape;
  for (const auto& p : part.points) {
    if (p.kind != LoopKind::kPrint) {
      shape.push_back((p.position - symmetry.center) / part.radius);
    }
  }
  const NearOutline near(shape, tolerance);
  std::vector<Turn> found = findTurns(shape, near, symmetry, share_min);
  // Exact symmetries of the shape matter only where a print tells them apart.
  found.erase(std::remove_if(found.begin(), found.end(),
                             [&](const Turn& turn) { return isExact(turn, symmetry); }),
              found.end());
  std::stable_sort(found.begin(), found.end(),
                   [](const Turn& a, const Turn& b) { return a.share > b.share; });
  const int order = std::max(1, symmetry.order);
  std::vector<NearSymmetry> out;
  for (int k = 0; k < order && part.has_print; ++k) {
    const double angle = 2.0 * M_PI * k / order;
    if (k > 0) out.push_back({turned(part, false, angle), false, true, {}, {}});
    if (symmetry.mirror) {
      out.push_back({turned(part, true, 2.0 * symmetry.mirror_axis + angle), true, true, {}, {}});
    }
  }
  for (const auto& f : found) {
    NearSymmetry other{turned(part, f.flip, f.angle), f.flip, false, {}, {}};
    const Eigen::Matrix2d there = mapping(f.flip, f.angle), back = there.transpose();
    for (std::size_t i = 0; i < shape.size(); ++i) {  // shape points come first in outline()
      if (!near(there * shape[i])) other.only_turned.push_back(static_cast<int>(i));
      if (!near(back * shape[i])) other.only_part.push_back(static_cast<int>(i));
    }
    out.push_back(std::move(other));
  }
  return out;
}

int findNearOrder(const OutlineShape& part, const std::vector<NearSymmetry>& near_symmetries,
                  double share_min) {
  const int order = part.symmetry.order;
  if (order == 0) return 0;
  const double range = 2.0 * M_PI / order;
  std::vector<double> angles;  // of the turns that all but keep the shape, in (0, range)
  const double shape = static_cast<double>(
      std::count_if(part.points.begin(), part.points.end(),
                    [](const OutlinePoint& p) { return p.kind != LoopKind::kPrint; }));
  for (const auto& other : near_symmetries) {
    if (other.flips || other.exact || other.only_turned.size() > (1.0 - share_min) * shape)
      continue;
    const Eigen::Matrix3d& R = other.T_part_turned.linear();
    angles.push_back(std::fmod(std::atan2(R(1, 0), R(0, 0)) + 2.0 * M_PI, range));
  }
  const auto has = [&](double angle) {
    return std::any_of(angles.begin(), angles.end(),
                       [angle](double a) { return std::abs(a - angle) < kOrderNear; });
  };
  for (int n = static_cast<int>(angles.size()) + 1; n > 1; --n) {
    bool all = true;
    for (int k = 1; k < n && all; ++k) all = has(range * k / n);
    if (all) return n * order;
  }
  return order;
}

}  // namespace planar_bin_picking
