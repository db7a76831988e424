// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/judge/rank.h"

#include "base/polygon.h"
#include "locate/judge/explained.h"
#include "locate/judge/probability.h"

#include <algorithm>
#include <utility>

namespace planar_bin_picking {
namespace {

constexpr std::size_t kStride = 4;  // of the outline's samples: overlap needs no fine polygon
constexpr int kGrid = 16;  // points to a side by which an overlap is estimated: to some per cent
/// Share of a print from which on it is surely seen: chance confirms 0.1 to 0.3 (print_evidence.h).
constexpr double kPrintSeen = 0.6;
/// Share of the evidence that a printed pose must have of the one it replaces: a print that is only
/// just seen lowers it, a mean, by up to a fifth.
constexpr double kNearly = 0.75;

/// Inlier score of what better poses leave unexplained: combs in the gaps of combs have 0.06 to
/// 0.12, right poses among neighbours that touch them 0.45 and more.
constexpr double kOwnScore = 0.3;

/// Coarse mask of a posed part in the ideal image plane.
struct Mask {
  std::size_t part;
  Eigen::AlignedBox2d box;
  std::vector<Eigen::Vector2d> outer;
  std::vector<Eigen::Vector2d> within;  // points of a grid
};

Mask maskOf(const PartModel& part, const ScoredPose& pose) {
  Mask mask{pose.part, {}, {}, {}};
  const double z = part.faceZ(pose.face);
  for (std::size_t k = 0; k < part.outline().size(); k += kStride) {
    const OutlinePoint& p = part.outline()[k];
    if (p.kind != LoopKind::kOuter) continue;
    const Eigen::Vector3d q =
        pose.T_camera_part * Eigen::Vector3d(p.position.x(), p.position.y(), z);
    mask.outer.push_back(q.hnormalized());
    mask.box.extend(mask.outer.back());
  }
  for (int j = 0; j < kGrid; ++j) {
    for (int i = 0; i < kGrid; ++i) {
      const Eigen::Vector2d p =
          mask.box.min() + mask.box.sizes().cwiseProduct(Eigen::Vector2d(i + 0.5, j + 0.5) / kGrid);
      if (contains(mask.outer, p)) mask.within.push_back(p);
    }
  }
  return mask;
}

/// Share of a's area that b covers too.
double overlap(const Mask& a, const Mask& b) {
  if (!a.box.intersects(b.box)) return 0.0;
  const auto both = std::count_if(a.within.begin(), a.within.end(), [&](const Eigen::Vector2d& p) {
    return b.box.contains(p) && contains(b.outer, p);
  });
  return static_cast<double>(both) / std::max(1.0, static_cast<double>(a.within.size()));
}

/// Share of the area in common: of one part the larger share; of two the smaller one, since a small
/// part may lie on a large one.
double common(const Mask& a, const Mask& b) {
  const auto shares = std::minmax({overlap(a, b), overlap(b, a)});
  return a.part == b.part ? shares.second : shares.first;
}

/// Best first. What lies free is picked first: a covered part may score high on what is left of it.
/// The score, a probability, is near 1 for most of them: the better confirmed ones first.
template <class Poses, class Get>
void sortByMerit(Poses* poses, const Get& get) {
  const auto merit = [&](const auto& pose) {
    const ScoredPose& s = get(pose);
    return s.evidence.edges * s.visible_fraction * s.visible_fraction;
  };
  std::stable_sort(poses->begin(), poses->end(),
                   [&](const auto& a, const auto& b) { return merit(a) > merit(b); });
}

/// Where a print is seen, a pose without one is wrong: the back of a part, another part without a
/// print.
std::vector<const ScoredPose*> withoutUnprinted(
    const std::vector<const ScoredPose*>& poses,
    const std::vector<std::shared_ptr<const PartModel>>& parts, double overlap_max) {
  std::vector<std::pair<const ScoredPose*, Mask>> printed;
  for (const auto* s : poses)
    if (s->print > kPrintSeen) printed.push_back({s, maskOf(*parts[s->part], *s)});
  std::vector<const ScoredPose*> out;
  for (const auto* s : poses) {
    const bool has_print = parts[s->part]->hasPrint() && s->face == Face::kFront;
    const bool outdone = !has_print && !printed.empty() && [&] {
      const Mask mask = maskOf(*parts[s->part], *s);
      return std::any_of(printed.begin(), printed.end(), [&](const auto& p) {
        return p.first->evidence.edges > kNearly * s->evidence.edges &&
               overlap(mask, p.second) > overlap_max && overlap(p.second, mask) > overlap_max;
      });
    }();
    if (!outdone) out.push_back(s);
  }
  return out;
}

}  // namespace

std::vector<Detection> rankPoses(const std::vector<ScoredPose>& scored,
                                 const std::vector<std::shared_ptr<const PartModel>>& parts,
                                 double score_min, const RankParams& params) {
  std::vector<const ScoredPose*> order;
  for (const auto& s : scored) {
    if (s.score >= score_min) order.push_back(&s);
  }
  order = withoutUnprinted(order, parts, params.overlap_max);
  sortByMerit(&order, [](const ScoredPose* s) -> const ScoredPose& { return *s; });
  std::vector<Detection> out;
  std::vector<Mask> masks;
  ExplainedEdges explained(order);
  for (const auto* s : order) {
    const Mask mask = maskOf(*parts[s->part], *s);
    const bool taken = std::any_of(masks.begin(), masks.end(), [&](const Mask& m) {
      return common(mask, m) > params.overlap_max;
    });
    if (taken) continue;
    if (explained.ownScore(*s) < kOwnScore) continue;
    explained.add(*s);
    Detection d;
    static_cast<ScoredPose&>(d) = *s;
    d.part_name = parts[s->part]->name();
    d.evidence.edges *= probabilityOfTilt(d);
    out.push_back(d);
    masks.push_back(mask);
  }
  // Only now: it may be a wrong one of two at one place that seems sure.
  sortByMerit(&out, [](const Detection& d) -> const ScoredPose& { return d; });
  return out;
}

}  // namespace planar_bin_picking
