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
inline double wallWidth(const Solid& solid, const PosedPoint& at) {
  return std::max(0.0, solid.far_contour * at.deep_px);
}

struct SearchProfile {
  int reach_px = 6;       ///< how far along the normal an edge is sought, at most 16
  bool paired = false;    ///< two profiles side by side: less noise, and the gradient's direction
  double sigma_px = 1.0;  ///< of the derivative filter
};

/// Searches on one kind of profile; the filters are made once.
class EdgeSearch {
 public:
  static constexpr int kTaps = 3;  // of the derivative filter on either side
  /// Derivatives of a Gaussian for a step (odd) and for a line (even), j = -kTaps..kTaps.
  struct Filters {
    std::array<float, kTaps> odd{};       // j = 1..kTaps; a unit step answers with 1
    std::array<float, kTaps + 1> even{};  // j = 0..kTaps; sums to zero
  };

  static constexpr int kMaxReach = 16;  // of SearchProfile::reach_px: buffers of fixed size
  /// What the filters answer at the places of a profile, the first one reach_px + 1 inside;
  /// set only where the profile is complete, and no farther than places().
  struct Response {
    using Places = std::array<float, 2 * kMaxReach + 3>;
    bool complete = false;  ///< whether the profile lies in the image
    int level = 0;          ///< grey level at the point
    Places step, line;      ///< heights, grey levels
    Places across;          ///< slope along the contour, grey levels per pixel; 0 without a pair
  };

  EdgeSearch(const EdgeMap& edges, const SearchProfile& profile);

  int places() const { return 2 * profile_.reach_px + 3; }
  Response respond(const PosedPoint& point) const;
  /// The strongest edge on the profile, nearer ones preferred; its wall_px is not set.
  /// @param noise_share  of the image's noise that is left in the response
  EdgeHit strongest(const Response& response, float noise_share = 1.0f) const;
  EdgeHit at(const PosedPoint& point) const { return strongest(respond(point)); }

 private:
  const EdgeMap& edges_;
  SearchProfile profile_;
  Filters filters_;
};

/// Where each point would find its edge, together with its neighbours along the contour: these
/// agree on a faint edge, but not on noise or texture. The points in order along their loops.
/// Cost: O(points * reach).
void findHits(const EdgeMap& edges, const Camera& camera, const std::vector<LocalPoint>& points,
              const Solid& solid, const Eigen::Isometry3d& T_camera_centre,
              const SearchProfile& profile, std::vector<EdgeHit>* hits);

}  // namespace planar_bin_picking
