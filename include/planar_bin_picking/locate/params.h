// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// All parameters of the localization. Each stage's struct holds its defaults, the only place where
/// a default is written, and beside them one list of (key, member, min, max). That list drives
/// loading, validation, printing and the tests.

#include <string>
#include <type_traits>

namespace planar_bin_picking {

/// Stage 1, edges.h.
struct EdgesParams {
  double noise_factor = 4.0;  ///< an edgel's gradient is at least this many times its noise
  /// An edgel weaker than this many times the mean gradient about it may be texture ...
  double texture_factor = 2.0;
  double texture_cost_px = 1.33;  ///< ... and counts as so many field pixels farther
  double megapixels = 1.3;        ///< edges are sought in the image shrunk to about this size
  /// A part whose radius has more pixels than this is sought in an image that is shrunk until it
  /// has about so many: noise and the texture of floors average out, its outline does not.
  double radius_px = 110.0;
  double direction_cost_px = 1.0;  ///< field pixels that one direction bin off counts as

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("noise_factor", self.noise_factor, 1.0, 50.0);
    visit("texture_factor", self.texture_factor, 0.0, 20.0);
    visit("texture_cost_px", self.texture_cost_px, 0.0, 20.0);
    visit("megapixels", self.megapixels, 0.1, 50.0);
    visit("radius_px", self.radius_px, 20.0, 1000.0);
    visit("direction_cost_px", self.direction_cost_px, 0.0, 20.0);
  }
};

/// Stage 2, hough.h.
struct HoughParams {
  double radius_cells = 14.0;    ///< cells of the accumulator along the part's radius
  double tolerance_cells = 1.0;  ///< an edgel this far off still counts a little
  double yaw_step_deg = 5.0;
  double distance_step = 0.06;  ///< relative
  double tilt_max_deg = 40.0;
  int raster_points = 80;  ///< along the outline
  double votes_min = 0.3;  ///< share of the highest possible vote
  int tile_cells = 4;
  int max_candidates = 800;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("radius_cells", self.radius_cells, 4.0, 64.0);
    visit("tolerance_cells", self.tolerance_cells, 0.25, 4.0);
    visit("yaw_step_deg", self.yaw_step_deg, 0.5, 30.0);
    visit("distance_step", self.distance_step, 0.005, 0.5);
    visit("tilt_max_deg", self.tilt_max_deg, 0.0, 60.0);
    visit("raster_points", self.raster_points, 16, 85);
    visit("votes_min", self.votes_min, 0.0, 1.0);
    visit("tile_cells", self.tile_cells, 1, 64);
    visit("max_candidates", self.max_candidates, 2, 100000);
  }
};

/// Stage 3, refine.h.
struct RefineParams {
  /// Theta_lim of Eq. (7): beyond, a pose is penalised; what stays beyond is not answered
  /// (locator.h).
  double tilt_limit_deg = 40.0;
  int field_points = 64;
  int field_iterations = 14;
  double field_reach_radii = 0.13;  ///< radii of the part within which an edgel attracts, at first
  double field_reach_end_px = 2.0;  ///< field pixels, at last
  double field_inliers_min = 0.45;  ///< poses below are dropped before the image is looked at
  int min_poses = 25;               ///< of a part that go on to the image even below
  int max_poses = 400;              ///< of a part that go on to the image
  double image_inliers_min = 0.4;   ///< poses below are dropped after the first look at the image
  double search_below = 0.92;       ///< poses with a higher inlier score need no search about them
  double search_inliers_min = 0.5;  ///< poses below are dropped after the search
  int wide_points = 128;
  int image_points = 320;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("tilt_limit_deg", self.tilt_limit_deg, 0.0, 80.0);
    visit("field_points", self.field_points, 16, 512);
    visit("field_iterations", self.field_iterations, 1, 100);
    visit("field_reach_radii", self.field_reach_radii, 0.01, 1.0);
    visit("field_reach_end_px", self.field_reach_end_px, 0.5, 20.0);
    visit("field_inliers_min", self.field_inliers_min, 0.0, 1.0);
    visit("min_poses", self.min_poses, 0, 10000);
    visit("max_poses", self.max_poses, 1, 10000);
    visit("image_inliers_min", self.image_inliers_min, 0.0, 1.0);
    visit("search_below", self.search_below, 0.0, 1.0);
    visit("search_inliers_min", self.search_inliers_min, 0.0, 1.0);
    visit("wide_points", self.wide_points, 32, 512);
    visit("image_points", self.image_points, 32, 2048);
  }
};

/// Where a plane is known, plane_prior.h.
struct PlaneParams {
  double distance = 0.0;  ///< metres from the camera's centre, along the normal; 0 = no plane
  /// Camera frame, toward the camera, any length.
  double normal_x = 0.0, normal_y = 0.0, normal_z = -1.0;
  double sigma = 0.0005;        ///< metres, of a face's height: of plane and thickness together
  double sigma_tilt_deg = 0.2;  ///< of a face against the plane: of plane and part together
  double gate = 6.0;            ///< sigmas off the plane from which on a pose is dropped

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("distance", self.distance, 0.0, 100.0);
    visit("normal_x", self.normal_x, -1.0, 1.0);
    visit("normal_y", self.normal_y, -1.0, 1.0);
    visit("normal_z", self.normal_z, -1.0, -0.1);
    visit("sigma", self.sigma, 1e-6, 0.1);
    visit("sigma_tilt_deg", self.sigma_tilt_deg, 0.001, 45.0);
    visit("gate", self.gate, 1.0, 1000.0);
  }
};

/// Stage 4, score.h.
struct ScoreParams {
  double threshold = 0.4;         ///< less probable detections are not returned
  double reach_px = 1.5;          ///< an edge this far off the outline is no inlier
  int points = 256;               ///< along each of outer contour, holes, print
  double visible_reach_px = 2.5;  ///< the same, for what counts as seen

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("threshold", self.threshold, 0.0, 1.0);
    visit("reach_px", self.reach_px, 0.2, 10.0);
    visit("points", self.points, 32, 2048);
    visit("visible_reach_px", self.visible_reach_px, 0.2, 10.0);
  }
};

/// Stage 5, rank.h.
struct RankParams {
  double overlap_max = 0.5;  ///< more of either outline (two parts: both) shared: the better stays

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("overlap_max", self.overlap_max, 0.0, 1.0);
  }
};

/// Several views of one part, views/look.h.
struct ViewsParams {
  /// Standard deviations per axis of where the camera was at a picture: of the robot's pose, anew
  /// at each stop, and of the hand-eye calibration, the same at all.
  double robot_sigma = 0.0001;  ///< metres
  double robot_sigma_deg = 0.01;
  double hand_eye_sigma = 0.0002;  ///< metres
  double hand_eye_sigma_deg = 0.02;
  double depth_reach = 0.015;  ///< metres by which a pose may be too near or far and is found yet

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("robot_sigma", self.robot_sigma, 0.0, 0.1);
    visit("robot_sigma_deg", self.robot_sigma_deg, 0.0, 10.0);
    visit("hand_eye_sigma", self.hand_eye_sigma, 0.0, 0.1);
    visit("hand_eye_sigma_deg", self.hand_eye_sigma_deg, 0.0, 10.0);
    visit("depth_reach", self.depth_reach, 0.001, 0.1);
  }
};

struct LocatorParams {
  EdgesParams edges;
  HoughParams hough;
  RefineParams refine;
  PlaneParams plane;
  ScoreParams score;
  RankParams rank;
  ViewsParams views;
  int threads = 0;  ///< 0 = as many as the machine has cores
};

/// Calls visit(key, member, min, max) for every parameter, keys as in config/locator.yaml with the
/// stage in front ("hough/yaw_step_deg"). `Params` is LocatorParams or const LocatorParams; a
/// member is an int, a double or a bool.
template <class Params, class Visit>
void forEachField(Params& params, Visit&& visit) {
  const auto stage = [&visit](const std::string& name, auto& self) {
    std::decay_t<decltype(self)>::fields(self,
                                         [&](const char* key, auto& member, auto min, auto max) {
                                           visit(name + "/" + key, member, min, max);
                                         });
  };
  stage("edges", params.edges);
  stage("hough", params.hough);
  stage("refine", params.refine);
  stage("plane", params.plane);
  stage("score", params.score);
  stage("rank", params.rank);
  stage("views", params.views);
  visit(std::string("threads"), params.threads, 0, 64);
}

/// @throws std::invalid_argument  the first field out of its range: key, value, allowed range
void validate(const LocatorParams& params);

/// Reads the YAML file (nested maps, keys as in forEachField) over the defaults.
/// @throws std::runtime_error  file unreadable; unknown key, wrong type or value out of range, by
/// name
LocatorParams loadLocatorParams(const std::string& path);

}  // namespace planar_bin_picking
