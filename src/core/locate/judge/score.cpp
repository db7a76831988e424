// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/judge/score.h"

#include "base/parallel.h"
#include "locate/evidence/inlier_score.h"
#include "locate/evidence/print_evidence.h"
#include "locate/judge/occlusion.h"
#include "part/outline_view.h"

#include <array>

namespace planar_bin_picking {
namespace {

constexpr SearchProfile kReach{3, true, 0.8};

/// The outline's points by kind, in order along the loops.
struct Groups {
  std::array<std::vector<LocalPoint>, 3> points;  // by LoopKind
  std::array<double, 3> length{};                 // metres
};

Groups groupsOf(const PartModel& part, int count) {
  Groups out;
  for (const auto kind : {LoopKind::kOuter, LoopKind::kHole, LoopKind::kPrint}) {
    out.points[static_cast<int>(kind)] =
        localPoints(part, count, [kind](const OutlinePoint& p) { return p.kind == kind; });
  }
  for (const Loop& loop : part.file().drawing.loops)
    out.length[static_cast<int>(loop.kind)] += lengthOf(loop);
  return out;
}

/// The pieces of the outline that the points stand for.
void addPieces(const PartModel& part, const std::vector<LocalPoint>& points, double length,
               const std::vector<EdgeHit>& hits, double reach_px,
               std::vector<OutlinePiece>* pieces) {
  constexpr double kBorneOut = 0.4;  // texture, noise and foreign edges give less, mostly
  for (std::size_t i = 0; i < points.size(); ++i) {
    const OutlinePoint& p = part.outline()[points[i].index];
    pieces->push_back({p.position, p.normal, length / static_cast<double>(points.size()),
                       supportOf(hits[i], reach_px) > kBorneOut});
  }
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
    std::vector<OutlinePiece> pieces;
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
      addPieces(part, points, groups[r.part].length[static_cast<int>(kind)], hits,
                params.visible_reach_px, &pieces);
    }
    out[i].score = sum / count;
    const FaceGrid& grid = part.faceGrid();
    out[i].covered =
        findOcclusion(grid, edges, camera, r.T_camera_part, part.faceZ(r.face), pieces);
    out[i].visible_fraction =
        1.0 - static_cast<double>(out[i].covered.size()) / static_cast<double>(grid.cells().size());
  });
  return out;
}

}  // namespace planar_bin_picking
