// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/locate/locate_request.h"

#include <algorithm>
#include <cmath>
#include <locale>
#include <sstream>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

constexpr double kSigmas = 3.0;      // of the pose's own uncertainty
constexpr double kLeast = 0.002;     // metres: as well as such distances are measured
constexpr double kMostShare = 0.02;  // of the depth: the error of a focal length

}  // namespace

void checkDistances(double distance_min, double distance_max) {
  // Written so that what is not a number is refused, too.
  const bool good = distance_min >= kDistanceLeast && distance_max <= kDistanceMost &&
                    distance_max >= distance_min &&
                    distance_max <= kDistanceRatioMost * distance_min;
  if (good) return;
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << "distances " << distance_min << " .. " << distance_max << " m; they must satisfy "
       << kDistanceLeast << " <= min <= max <= " << kDistanceMost
       << " and max <= " << kDistanceRatioMost << " min";
  throw std::invalid_argument("locate: " + text.str());
}

double distanceMargin(const Detection& detection, double depth) {
  const Eigen::Vector3d ray = detection.T_camera_part.linear().row(2);
  const double variance = ray.dot(detection.covariance.topLeftCorner<3, 3>() * ray);
  const double margin = kSigmas * std::sqrt(std::max(0.0, variance));
  return std::clamp(margin, kLeast, std::max(kLeast, kMostShare * depth));
}

}  // namespace planar_bin_picking
