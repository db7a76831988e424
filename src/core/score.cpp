// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/score.h"

#include "evidence.h"
#include "outline_view.h"
#include "parallel.h"
#include "print_evidence.h"

#include <array>
#include <cmath>

namespace planar_bin_picking {
namespace {

constexpr ImageReach kReach{3, true, 0.8};

/// The outline's points by kind, in order along the loops.
struct Groups {
  std::array<std::vector<LocalPoint>, 3> points;  // by LoopKind
};

Groups groupsOf(const PartModel& part, int count) {
  Groups out;
  for (const auto kind : {LoopKind::kOuter, LoopKind::kHole, LoopKind::kPrint}) {
    out.points[static_cast<int>(kind)] =
        localPoints(part, count, [kind](const OutlinePoint& p) { return p.kind == kind; });
  }
  return out;
}

/// Share of the outer contour that is seen, faint stretches bridged: an estimate of the share of
/// the face that nothing covers. (Cutting off what lies beyond the chord of each gap, the obvious
/// alternative, is further from the truth: most covers lie across a part, not over a corner of it.)
double visibleFraction(const std::vector<EdgeHit>& hits, const ScoreParams& params) {
  const int n = static_cast<int>(hits.size());
  const int half = std::max(1, static_cast<int>(std::lround(0.5 * params.gap_min * n)));
  const auto borne = [&](int i) {
    return supportOf(hits[(i + n) % n], params.visible_reach_px) > 0.3 ? 1 : 0;
  };
  int window = 0, seen = 0;
  for (int i = -half; i <= half; ++i) window += borne(i);
  for (int i = 0; i < n; ++i) {
    seen += window > params.gap_share * (2 * half + 1) ? 1 : 0;
    window += borne(i + half + 1) - borne(i - half);
  }
  return static_cast<double>(seen) / n;
}

}  // namespace

std::vector<ScoredPose> scorePoses(const EdgeMap& edges, const Camera& camera,
                                   const std::vector<std::shared_ptr<const PartModel>>& parts,
                                   const std::vector<RefinedPose>& refined,
                                   const ScoreParams& params, int threads) {
  std::vector<Groups> groups;
  for (const auto& part : parts) groups.push_back(groupsOf(*part, params.points));
  std::vector<ScoredPose> out(refined.size());
  parallelFor(static_cast<int>(refined.size()), threads, [&](int i) {
    const RefinedPose& r = refined[i];
    const auto& part = *parts[r.part];
    static_cast<RefinedPose&>(out[i]) = r;
    const Eigen::Isometry3d T = r.T_camera_part * centreOf(part, r.face);
    double sum = 0.0;
    int count = 0;
    for (const auto kind : {LoopKind::kOuter, LoopKind::kHole, LoopKind::kPrint}) {
      auto points = groups[r.part].points[static_cast<int>(kind)];
      if (points.empty() || (kind == LoopKind::kPrint && r.face == Face::kBack)) continue;
      ++count;
      if (kind == LoopKind::kPrint) {
        sum += printSupport(edges, camera, points, part.radius(), T);
        continue;
      }
      moveInward(r.inset / part.radius(), &points);
      std::vector<EdgeHit> hits;
      findHits(edges, camera, points, solidOf(part, r.face), T, kReach, &hits);
      sum += meanSupport(hits, params.reach_px);
      if (kind == LoopKind::kOuter) out[i].visible_fraction = visibleFraction(hits, params);
    }
    out[i].score = sum / count;
  });
  return out;
}

}  // namespace planar_bin_picking
