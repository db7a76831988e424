// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Sub-pixel edges along the normals of a posed outline, in the raw image, with the full lens
/// model. Refinement aligns to them; score and evidence count them.

#include "image/edge_map.h"
#include "image/posed_point.h"
#include "part/outline_view.h"
#include "planar_bin_picking/image/camera.h"

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

namespace planar_bin_picking {

/// The edge that one outline point found on its normal.
struct EdgeHit {
  bool found = false;      ///< an edge above the noise within reach
  float offset_px = 0.0f;  ///< along the outward normal; negative = inside the outline
  float wall_px = 0.0f;    ///< how wide the side wall is seen outside the outline; 0 = turned away
  float cosine = 0.0f;     ///< |cos| between image gradient and normal, Eq. (12)
  float height = 0.0f;     ///< of the step or line, grey levels
};

/// Size of the body behind the outline.
struct Solid {
  double radius;             ///< metres
  double far_contour = 0.0;  ///< z of the far contour in the centre frame, radii
};

inline Solid solidOf(const PartModel& part, Face face) {
  return {part.radius(), farContourOf(part, face)};
}

/// Width of the side wall outside the outline, pixels.
/// @param deep_px  of the point, see PosedPoint
inline double wallWidth(const Solid& solid, double deep_px) {
  return std::max(0.0, solid.far_contour * deep_px);
}

struct SearchProfile {
  int reach_px = 6;       ///< how far along the normal an edge is sought, at most 16
  bool paired = false;    ///< two profiles side by side: less noise, and the gradient's direction
  double sigma_px = 1.0;  ///< of the derivative filter
};

/// Searches on one kind of profile; the filters are made once. Works on kLanes points at a time.
class EdgeSearch {
 public:
  static constexpr int kTaps = 3;  // of the derivative filter on either side
  /// Derivatives of a Gaussian for a step (odd) and for a line (even), j = -kTaps..kTaps.
  struct Filters {
    std::array<float, kTaps> odd{};       // j = 1..kTaps; a unit step answers with 1
    std::array<float, kTaps + 1> even{};  // j = 0..kTaps; sums to zero
  };

  static constexpr int kMaxReach = 16;  // of SearchProfile::reach_px: buffers of fixed size
  static constexpr int kLanes = PosedPoints::kLanes;
  static constexpr int kNoLevel = -1;
  using Hits = std::array<EdgeHit, kLanes>;

  /// What the filters answer at the places of many points' profiles, the first place reach_px + 1
  /// inside. By kind and place, point after point; about these lie zeros for kLanes points.
  class Responses {
   public:
    /// Heights; slope along the contour, of which there is one place more at either end. Nothing is
    /// set of that without a pair.
    enum Kind { kStep, kLine, kAcross };
    Responses(int places, int points);
    float* at(Kind kind, int place, int point) {
      return values_.get() + (kind * places_ + kind / kAcross + place) * pitch_ + kLanes + point;
    }
    const float* at(Kind kind, int place, int point) const {
      return const_cast<Responses*>(this)->at(kind, place, point);
    }
    int& level(int point) { return level_[point]; }
    int level(int point) const { return level_[point]; }
    int pitch() const { return pitch_; }  ///< from one place to the next

   private:
    int places_, pitch_;
    std::unique_ptr<float[]> values_;
    std::vector<int> level_;  // grey level at the point; kNoLevel: the profile leaves the image
  };

  /// The stretches of neighbours about kLanes points: how many there are before and behind, and
  /// how much of the image's noise is left in their mean.
  struct Stretches {
    std::array<int, kLanes> before{}, behind{};
    std::array<float, kLanes> noise_share;
    Stretches() { noise_share.fill(1.0f); }
  };

  EdgeSearch(const EdgeMap& edges, const SearchProfile& profile);

  int places() const { return 2 * profile_.reach_px + 3; }
  Responses responsesOf(int points) const { return {places(), points}; }
  /// Sets the responses of kLanes points from `first` on.
  void respond(const PosedPoints& points, int first, Responses* out) const;
  /// The strongest edge on each of the profiles from `first` on, nearer ones preferred, by the mean
  /// of each stretch; its wall_px is not set.
  Hits strongest(const Responses& responses, int first, const Stretches& stretches) const;

 private:
  const EdgeMap& edges_;
  SearchProfile profile_;
  Filters filters_;
};

/// Where each point would find its edge, each by itself.
/// @param points  where they are seen, kLanes to a block
/// @param hits    as many as the blocks have lanes
void findEach(const EdgeMap& edges, const SearchProfile& profile,
              const std::vector<PosedPoints>& points, std::vector<EdgeHit>* hits);

/// Where each point would find its edge, together with its neighbours along the contour: these
/// agree on a faint edge, but not on noise or texture. The points in order along their loops.
/// Cost: O(points * reach).
void findHits(const EdgeMap& edges, const Camera& camera, const std::vector<LocalPoint>& points,
              const Solid& solid, const Eigen::Isometry3d& T_camera_centre,
              const SearchProfile& profile, std::vector<EdgeHit>* hits);

}  // namespace planar_bin_picking
