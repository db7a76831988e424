// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Types that pass between the stages of the localization.
///
/// Data flows one way and changes its type at every step:
///
///     cv::Mat -> EdgeMap -> Candidate -> RefinedPose -> ScoredPose -> Detection
///               edges.h     hough.h      refine.h       score.h       rank.h
///
/// Between refine.h and score.h a prior is fused with each RefinedPose: plane_prior.h where a plane
/// is known, else scene_plane_prior.h.
///
/// Frames: `part` is the drawing's frame (x right, y up as drawn, z out of the drawn front face,
/// the body in -thickness <= z <= 0); `camera` is the optical frame (x right, y down, z forward).
/// Transforms are `T_target_source`: x_camera = T_camera_part * x_part. Metres and radians;
/// anything else wears its unit in its name. Pixel (0, 0) is the centre of the top-left pixel.
///
/// References, cited as [n] all over the package:
///  [1] A. Pretto, S. Tonello, E. Menegatti: Flexible 3D localization of planar objects for
///      industrial bin-picking with monocamera vision system. IEEE CASE 2013.
///  [2] M. Imperoli, A. Pretto: D2CO: Fast and robust registration of 3D textureless objects using
///      the directional chamfer distance. ICVS 2015.
///  [3] S. Hinterstoisser et al.: Gradient response maps for real-time detection of textureless
///      objects. IEEE TPAMI 34(5), 2012.
///  [4] T. Collins, A. Bartoli: Infinitesimal plane-based pose estimation. IJCV 109(3), 2014.
///  [5] P. Debevec, J. Malik: Recovering high dynamic range radiance maps from photographs. ACM
///      SIGGRAPH 1997.

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace planar_bin_picking {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// The face of a part that is up, that is, toward the camera.
enum class Face : std::uint8_t { kFront, kBack };

/// Which faces a caller accepts.
enum class FaceFilter : std::uint8_t { kAny, kFront, kBack };

/// Metres along the optical axis.
struct Distances {
  double min = 0.0, max = 0.0;
};

/// The points x of the camera frame with normal . x = -distance.
struct Plane {
  Eigen::Vector3d normal_camera = -Eigen::Vector3d::UnitZ();  ///< unit, toward the camera
  double distance = 0.0;                                      ///< metres, > 0
};

/// A rough pose from voting: off by cells and steps, mostly false.
struct Candidate {
  std::size_t part = 0;  ///< index into the parts given to Locator::locate
  Face face = Face::kFront;
  Eigen::Isometry3d T_camera_part = Eigen::Isometry3d::Identity();
  double votes = 0.0;  ///< mean vote of the outline's raster points, 0..1
};

/// A pose aligned to the image.
struct RefinedPose {
  std::size_t part = 0;
  Face face = Face::kFront;
  Eigen::Isometry3d T_camera_part = Eigen::Isometry3d::Identity();
  /// Of xi = [translation; rotation] in T <- T * exp(xi) (se3.h), about the centre of the outline.
  Matrix6d covariance = Matrix6d::Zero();
  double edge_offset = 0.0;  ///< metres by which edges lie inside the drawn outline (bevel)
  double residual_px = 0.0;  ///< robust spread of edge minus outline along the outline's normal
  /// To the pose that looks nearly the same, tilted the other way about the line of sight, as xi,
  /// times the square root of its probability: that of another tilt adds its square to the
  /// covariance of the answer.
  Vector6d other_tilt = Vector6d::Zero();
};

/// A point of a posed outline in the image, and how well its edge was found there.
struct OutlineEvidence {
  Eigen::Vector2f pixel, normal;  ///< in the image; the normal points out of the material
  float inlier = 0.0f;            ///< 0..1, see locate/evidence/inlier_score.h
  float weight = 0.0f;            ///< of the point in the score
};

/// What speaks for and against a pose.
struct PoseEvidence {
  /// 0..1: mean inlier score of outer contour, holes and print, less what contradicts the pose
  /// (locate/judge/score.h); of an answer also less where its tilt is open (locate/judge/rank.h).
  double edges = 0.0;
  std::optional<double> holes;           ///< 0..1: of those that the picture resolves
  std::optional<double> beyond_corners;  ///< 0..1: how far edges go on beyond the part's corners
  /// How far the part could slide within its own plane without the picture telling: the largest
  /// standard deviation, in radii of the part and in pixels.
  double slide_radii = 0.0, slide_px = 0.0;
};

/// A refined pose with the evidence for and against it.
struct ScoredPose : RefinedPose {
  double score = 0.0;  ///< 0..1: how probable it is that the pose is right, locate/judge/score.h
  PoseEvidence evidence;
  double print = 0.0;             ///< share of the print in view that is seen, 0..1
  double visible_fraction = 0.0;  ///< share of the visible face's area that nothing covers, 0..1
  std::vector<OutlineEvidence> outline;  ///< contour and holes, as far as they lie in the image
  std::vector<int> covered;  ///< the cells of PartModel::faceGrid() that something covers
};

/// One located part, as the robot program gets it.
struct Detection : ScoredPose {
  std::string part_name;
  int views = 1;  ///< pictures that the pose rests on, see views/look.h
};

/// What the stages did and how long each took; the core's replacement for logging.
struct Report {
  struct Stage {
    std::string name;      ///< edges, hough, refine, plane (where one is known), score, rank
    double seconds = 0.0;  ///< wall time
    std::size_t out = 0;   ///< how many things it passed on
  };
  std::vector<Stage> stages;
  double seconds = 0.0;  ///< image in memory to ranked list
};

}  // namespace planar_bin_picking
