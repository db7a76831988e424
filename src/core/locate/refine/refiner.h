// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Steps of stage 3 that refine.cpp puts in order: poses on their way from candidate to
/// RefinedPose.

#include "base/parallel.h"
#include "image/edge_map.h"
#include "locate/refine/image_alignment.h"
#include "locate/refine/refine.h"
#include "part/outline_view.h"
#include "planar_bin_picking/image/camera.h"
#include "planar_bin_picking/part/part_model.h"

#include <array>
#include <memory>
#include <optional>
#include <vector>

namespace planar_bin_picking {

/// A pose on its way through the levels, with its support at the last one.
struct Tracked {
  std::size_t part;
  Face face;
  Eigen::Isometry3d T_camera_part;
  double support;
  ImagePose image;  // of this very pose; the default until it is aligned in the image
  /// Where `ambiguous`, the same with the same face up, but tilted the other way: the image cannot
  /// tell them apart.
  Eigen::Isometry3d T_camera_twin = Eigen::Isometry3d::Identity();
  bool ambiguous = false;
  bool searched = false;  // about this very pose, in vain
};

/// The shape's points where the edges of one face are seen.
struct FaceOutline {
  std::vector<LocalPoint> coarse, wide, fine;
  // Metres; the mean over the copies, its standard deviation and that of one copy about it.
  double inset = 0.0, inset_sigma = 0.0, inset_spread = 0.0;
};

/// What the levels need of a part, made once per call.
struct Outline {
  const PartModel* part;
  double grain;  // see grainOf
  std::vector<LocalPoint> field, print;
  std::array<FaceOutline, 2> faces;  // by Face

  const FaceOutline& of(Face face) const { return faces[static_cast<int>(face)]; }
};

/// Pixels off the outline at which an edge no longer supports it, after narrow alignment.
inline constexpr double kSupportNarrow = 1.7;

class Refiner {
 public:
  Refiner(const EdgeMap& edges, const Camera& camera, const RefineParams& params,
          const std::vector<std::shared_ptr<const PartModel>>& parts, int threads);

  template <class Step>
  void forAll(std::vector<Tracked>* poses, Step&& step) const {
    parallelFor(static_cast<int>(poses->size()), threads_, [&](int i) { step(&(*poses)[i]); });
  }

  /// In the distance field.
  std::vector<Tracked> settle(const std::vector<Candidate>& candidates) const;
  /// In the image, from what the field leaves (a small share of the part's size) to within the
  /// narrow reach.
  void alignWide(Tracked* pose) const;
  void alignNarrow(Tracked* pose) const;
  /// Restarts about a settled pose, since a neighbour's edge or a shadow may hold a side of the
  /// outline and with it the pose: farther and nearer ([1] Sec. III-E goes farther only), tilted to
  /// all sides. Does nothing where that was in vain before.
  void searchAround(Tracked* pose) const;

  /// Best first, at most max_poses of a part; of poses that agree within `distance` radii only the
  /// best stays.
  std::vector<Tracked> withoutTwins(std::vector<Tracked> poses, double distance,
                                    double support_min) const;
  /// Without those that a clearly better pose of the same place outdoes.
  std::vector<Tracked> withoutOutdone(const std::vector<Tracked>& poses) const;

  /// Each pose gives way to its best lookalike.
  void resolve(Tracked* pose) const;
  /// Parts rest on one another and on one floor: where the image cannot tell the tilt's sign, the
  /// one nearer to the way most parts lie is taken.
  void settleTilts(std::vector<Tracked>* poses) const;

  /// How far the edges are seen inside the drawn outline: a bevelled, rounded or sheared cut shifts
  /// the edges of a copy all around, those of the two faces by different amounts, and the light
  /// that a copy gets decides how far. One mean per part and face, from all well supported poses,
  /// unknown to 0.15 mm beforehand, and the spread of the copies about it; from then on the outline
  /// is taken to lie at the mean.
  void estimateInsets(const std::vector<Tracked>& poses);

  /// Whether enough edges hold the pose, and the camera can see the face that it says is up.
  bool isHeld(const Tracked& pose) const;
  /// @pre isHeld
  RefinedPose finish(const Tracked& pose) const;

 private:
  int wideReach(const Tracked& pose) const;
  template <std::size_t N>
  void align(const std::vector<LocalPoint>& points, const SearchProfile& reach,
             const std::array<double, N>& tukey_px, Tracked* pose) const;
  double supportAt(const Tracked& pose, const std::vector<LocalPoint>& points,
                   double reach_px) const;
  double supportOn(const Tracked& pose, const PartModel& part,
                   const std::vector<int>& indices) const;
  double supportInFieldOn(const Tracked& pose, const PartModel& part,
                          const std::vector<int>& indices) const;
  std::optional<Tracked> tiltTwin(const Tracked& pose) const;
  void resolveTilt(Tracked* pose) const;
  void resolveShape(Tracked* pose) const;
  void resolvePrint(Tracked* pose) const;
  void estimateInset(const std::vector<Tracked>& poses, std::size_t part, Face face);

  const EdgeMap& edges_;
  const Camera& camera_;
  const RefineParams& params_;
  int threads_;
  std::vector<Outline> outlines_;
};

}  // namespace planar_bin_picking
