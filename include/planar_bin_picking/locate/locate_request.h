// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What a call of the locator asks for, and what it answers.

#include "planar_bin_picking/base/types.h"
#include "planar_bin_picking/part/part_model.h"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace planar_bin_picking {

/// Distances from the camera that can be asked for, metres along the optical axis. The accumulator
/// has one grain for all of them: at a larger ratio than this it would be too coarse for the far
/// ones.
inline constexpr double kDistanceLeast = 0.01, kDistanceMost = 100.0, kDistanceRatioMost = 10.0;

/// @throws std::invalid_argument  distances that are not numbers, outside of kDistanceLeast ..
///         kDistanceMost, not min <= max, or max over kDistanceRatioMost times min
void checkDistances(double distance_min, double distance_max);

/// A rectangle of a picture.
struct PixelBox {
  int left = 0, top = 0, width = 0, height = 0;
};

/// What is looked for in one image.
struct LocateRequest {
  /// Parts that may lie in the bin; all of them are returned, ranked together.
  std::vector<PartPtr> parts;
  /// Metres along the optical axis within which the centre of the visible face lies, give or take
  /// distanceMargin.
  double distance_min = 0.0, distance_max = 0.0;
  /// The face that is up. Where nobody can tell a part's faces apart (mirror-symmetric, no print),
  /// it is answered as the one asked for.
  FaceFilter face = FaceFilter::kAny;
  std::size_t max_parts = 0;  ///< of those that obey all of the above; 0 = all
  /// All that is looked at; nothing = the whole picture. What sticks out of it counts as cut off by
  /// the picture's border. It grows to hold the camera's principal point.
  std::optional<PixelBox> window;
  std::optional<Plane> plane;  ///< in place of the one that LocatorParams::plane may say
  /// Of a bin's floor, unit, camera frame, toward the camera: some parts lie flat on it, which is
  /// evidence where a picture leaves the sign of a tilt open.
  std::optional<Eigen::Vector3d> floor_normal;
};

/// Why something that was found is no detection.
enum class Withheld {
  kOutside,       ///< outside of the distances, or so far that the part has too few pixels
  kWrongFace,     ///< the other face is up than the request asks for
  kContradicted,  ///< another view shows that it is not there; never by the locator itself
};

struct WithheldDetection {
  Detection detection;
  Withheld reason;
  std::string text;  ///< what is wrong with it, in numbers
};

struct LocateResult {
  /// Best first; may be empty. They obey the request, their tilt is within refine/tilt_limit_deg
  /// (or beyond by three of its standard deviations, at most 2 degrees), and face and pose agree: z
  /// of the part points toward the camera where the front is up, else away from it.
  std::vector<Detection> detections;
  /// What else was found with at least the threshold's score, best first.
  std::vector<WithheldDetection> withheld;
  Report report;
};

/// By how many metres a part may lie outside of the distances: three standard deviations of its
/// depth, at least 2 mm, at most 2 % of the distance.
/// @param depth  of the centre of its visible face
double distanceMargin(const Detection& detection, double depth);

}  // namespace planar_bin_picking
