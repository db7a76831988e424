// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/calibrate/motion_limits.h"

#include "planar_bin_picking/base/se3.h"

#include <algorithm>
#include <cmath>
#include <locale>
#include <sstream>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

constexpr double kRadians = 3.14159265358979323846 / 180.0;
/// A piece of a way is looked at this often. Between two looks a point 1 m from the flange bends
/// off the straight line by less than kBend.
constexpr double kLookMetres = 0.02, kLookRadians = 1.0 * kRadians;
constexpr double kBendMetres = 1e-4, kBendRadians = 0.01 * kRadians;
/// Targets keep this from all limits: more than the usual reached_mm and reached_deg.
constexpr double kTargetMetres = 0.008, kTargetRadians = 1.0 * kRadians;
/// A way that leaves the limits is tried again with twice as many steps, so often.
constexpr int kFiner = 3;
constexpr std::size_t kPlaneSize = 4;

/// A flange's pose against the start, see motion_limits.h.
struct Coordinates {
  Eigen::Vector3d place;  ///< in the base frame, metres
  Eigen::Vector2d tilt;   ///< radians
  double roll = 0.0;      ///< radians
};

Eigen::Matrix3d swing(const Eigen::Vector2d& tilt) {
  const double angle = tilt.norm();
  if (angle < 1e-12) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, Eigen::Vector3d(tilt.x() / angle, tilt.y() / angle, 0.0))
      .toRotationMatrix();
}

Coordinates coordinatesOf(const Eigen::Isometry3d& T_base_start,
                          const Eigen::Isometry3d& T_base_flange) {
  Coordinates c;
  c.place = T_base_flange.translation();
  const Eigen::Matrix3d R = T_base_start.linear().transpose() * T_base_flange.linear();
  const Eigen::Vector3d z = R.col(2);
  const double aside = std::hypot(z.x(), z.y());
  c.tilt.setZero();
  // Upside down: about x, as good as any other axis.
  if (aside > 0.0) c.tilt = std::atan2(aside, z.z()) / aside * Eigen::Vector2d(-z.y(), z.x());
  if (aside <= 0.0 && z.z() < 0.0) c.tilt.x() = 180.0 * kRadians;
  const Eigen::Matrix3d turned = swing(c.tilt).transpose() * R;
  c.roll = std::atan2(turned(1, 0), turned(0, 0));
  return c;
}

Eigen::Isometry3d poseOf(const Eigen::Isometry3d& T_base_start, const Coordinates& c) {
  const Eigen::Matrix3d R = T_base_start.linear() * swing(c.tilt) *
                            Eigen::AngleAxisd(c.roll, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return rigid(nearestRotation(R), c.place);
}

[[noreturn]] void refuse(const std::string& key, double value, const std::string& expected) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << key << " is " << value << ", must be " << expected;
  throw std::invalid_argument(text.str());
}

void validateWorkspace(const MotionParams& p) {
  const double* const ends[] = {&p.workspace_min_x, &p.workspace_min_y, &p.workspace_min_z,
                                &p.workspace_max_x, &p.workspace_max_y, &p.workspace_max_z};
  if (std::all_of(std::begin(ends), std::end(ends), [](const double* e) { return *e == 0.0; })) {
    throw std::invalid_argument(
        "the workspace is not set: give workspace_min_x, _min_y, _min_z and workspace_max_x, "
        "_max_y, _max_z, metres in the base frame: where flange, camera and board may be");
  }
  const char* const keys[] = {"workspace_max_x", "workspace_max_y", "workspace_max_z"};
  for (std::size_t i = 0; i < 3; ++i) {
    if (!(*ends[i] < *ends[i + 3])) {
      refuse(keys[i], *ends[i + 3], "greater than its minimum, or the workspace is empty");
    }
  }
}

}  // namespace

void validate(const MotionParams& params) {
  MotionParams::fields(params, [](const std::string& key, double value, double min, double max) {
    if (value >= min && value <= max) return;
    std::ostringstream range;
    range.imbue(std::locale::classic());
    range << "between " << min << " and " << max;
    refuse(key, value, range.str());
  });
  validateWorkspace(params);
  if (params.planes.size() % kPlaneSize != 0) {
    refuse("the count of numbers in planes", static_cast<double>(params.planes.size()),
           "four for each plane: nx ny nz d");
  }
  for (std::size_t i = 0; i < params.planes.size(); i += kPlaneSize) {
    const Eigen::Vector3d n(params.planes[i], params.planes[i + 1], params.planes[i + 2]);
    if (!(std::abs(n.norm() - 1.0) < 1e-3) || !std::isfinite(params.planes[i + 3])) {
      refuse("the length of the normal of plane " + std::to_string(1 + i / kPlaneSize), n.norm(),
             "1, with a finite distance after it");
    }
  }
}

MotionLimits::MotionLimits(const MotionParams& params, const Eigen::Isometry3d& T_base_start)
    : params_(params), T_base_start_(T_base_start) {
  validate(params_);
  mounted_.margin = params_.mounted_radius_m;
  const std::string reason = whyNot(T_base_start_);
  if (!reason.empty()) {
    throw std::invalid_argument("the robot must not start here: " + reason +
                                "; move it, or change workspace_*, planes or mounted_radius_m");
  }
}

std::string MotionLimits::whyNotAt(const Eigen::Vector3d& x_base, double keep) const {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(3);
  const Eigen::Array3d x = x_base.array();
  const Eigen::Array3d min(params_.workspace_min_x, params_.workspace_min_y,
                           params_.workspace_min_z);
  const Eigen::Array3d max(params_.workspace_max_x, params_.workspace_max_y,
                           params_.workspace_max_z);
  if (!(x >= min + keep).all() || !(x <= max - keep).all()) {
    text << "[" << x_base.transpose() << "]";
    if (keep > kBendMetres) text << ", with " << keep << " m around it,";
    text << " lies outside the workspace";
    return text.str();
  }
  for (std::size_t i = 0; i < params_.planes.size(); i += kPlaneSize) {
    const Eigen::Vector3d n(params_.planes[i], params_.planes[i + 1], params_.planes[i + 2]);
    if (n.dot(x_base) >= params_.planes[i + 3] + keep) continue;
    text << "[" << x_base.transpose() << "]";
    if (keep > kBendMetres) text << ", with " << keep << " m around it,";
    text << " lies beyond plane " << 1 + i / kPlaneSize;
    return text.str();
  }
  return "";
}

std::string MotionLimits::whyNot(const Eigen::Isometry3d& T_base_flange, const Keep& keep) const {
  const std::string flange = whyNotAt(T_base_flange.translation(), keep.metres);
  if (!flange.empty()) return "the flange at " + flange;
  for (const Eigen::Vector3d& point : mounted_.points) {
    const std::string reason = whyNotAt(T_base_flange * point, mounted_.margin + keep.metres);
    if (!reason.empty()) return "what is mounted on the flange, at " + reason;
  }
  const Coordinates c = coordinatesOf(T_base_start_, T_base_flange);
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(3);
  // At its largest a limit is none.
  if (params_.cone_deg < 180.0 && !(c.tilt.norm() <= params_.cone_deg * kRadians - keep.radians)) {
    text << "the flange's z axis is " << c.tilt.norm() / kRadians
         << " deg from where it was at the start, outside cone_deg";
  } else if (params_.max_roll_deg < 180.0 &&
             !(std::abs(c.roll) <= params_.max_roll_deg * kRadians - keep.radians)) {
    text << "the flange is turned about its own axis by " << c.roll / kRadians
         << " deg, beyond max_roll_deg";
  }
  return text.str();
}

std::string MotionLimits::whyNot(const Eigen::Isometry3d& T_base_flange) const {
  return whyNot(T_base_flange, {0.0, 0.0});
}

bool MotionLimits::allows(const Eigen::Isometry3d& T_base_flange) const {
  return whyNot(T_base_flange).empty();
}

bool MotionLimits::allowsTarget(const Eigen::Isometry3d& T_base_flange) const {
  return whyNot(T_base_flange, {kTargetMetres, kTargetRadians}).empty();
}

bool MotionLimits::allowsStep(const Eigen::Isometry3d& T_base_from,
                              const Eigen::Isometry3d& T_base_to) const {
  const Eigen::Vector3d step = T_base_to.translation() - T_base_from.translation();
  const Eigen::Vector3d turn =
      rotationVector(T_base_from.linear().transpose() * T_base_to.linear());
  if (!(step.norm() <= params_.max_step_m * (1.0 + 1e-9))) return false;
  if (!(turn.norm() <= params_.max_turn_deg * kRadians * (1.0 + 1e-9))) return false;
  const int looks =
      1 + static_cast<int>(std::max(step.norm() / kLookMetres, turn.norm() / kLookRadians));
  for (int i = 1; i < looks; ++i) {
    const double share = static_cast<double>(i) / looks;
    Eigen::Isometry3d T = T_base_from;
    T.translation() += share * step;
    const double angle = turn.norm();
    if (angle > 0.0) T.rotate(Eigen::AngleAxisd(share * angle, turn / angle));
    // What is between two looks; the ends themselves are exact.
    if (!whyNot(T, {kBendMetres, kBendRadians}).empty()) return false;
  }
  return allows(T_base_to);
}

std::optional<std::vector<Eigen::Isometry3d>> MotionLimits::wayOf(
    const Eigen::Isometry3d& T_base_here, const Eigen::Isometry3d& T_base_there, int steps) const {
  const Coordinates from = coordinatesOf(T_base_start_, T_base_here);
  const Coordinates to = coordinatesOf(T_base_start_, T_base_there);
  std::vector<Eigen::Isometry3d> poses;
  Eigen::Isometry3d T_base_last = T_base_here;
  for (int i = 1; i <= steps; ++i) {
    const double share = static_cast<double>(i) / steps;
    Coordinates c;
    c.place = from.place + share * (to.place - from.place);
    c.tilt = from.tilt + share * (to.tilt - from.tilt);
    c.roll = from.roll + share * (to.roll - from.roll);
    const Eigen::Isometry3d T = i == steps ? T_base_there : poseOf(T_base_start_, c);
    if (!allowsStep(T_base_last, T)) return std::nullopt;
    poses.push_back(T);
    T_base_last = T;
  }
  return poses;
}

std::optional<std::vector<Eigen::Isometry3d>> MotionLimits::way(
    const Eigen::Isometry3d& T_base_here, const Eigen::Isometry3d& T_base_there) const {
  if (!allows(T_base_here) || !allows(T_base_there)) return std::nullopt;
  const double step = (T_base_there.translation() - T_base_here.translation()).norm();
  const double turn = rotationAngle(T_base_here.linear().transpose() * T_base_there.linear());
  constexpr double kSameMetres = 1e-6, kSameRadians = 1e-6;
  if (step < kSameMetres && turn < kSameRadians) return std::vector<Eigen::Isometry3d>{};
  int steps = std::max(
      1,
      static_cast<int>(std::ceil(
          std::max(step / params_.max_step_m, turn / (params_.max_turn_deg * kRadians)) - 1e-9)));
  for (int i = 0; i <= kFiner; ++i, steps *= 2) {
    auto poses = wayOf(T_base_here, T_base_there, steps);
    if (poses) return poses;
  }
  return std::nullopt;
}

}  // namespace planar_bin_picking
