// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/pick/tool_room.h"

#include "base/polygon.h"
#include "image/edges.h"
#include "planar_bin_picking/locate/params.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

constexpr std::size_t kBodiesMost = 50;
constexpr double kLargest = 1.0;   // metres; a tool is measured in metres, not in millimetres
constexpr double kStep = 0.002;    // metres, between the lines that stand for a body
constexpr double kSheet = 0.0005;  // metres, a part of unknown thickness
constexpr double kFloorKnownTo =
    0.002;  // metres; a finger beside a part on the floor is near to it

[[noreturn]] void refuse(const std::string& key, const std::string& why) {
  throw std::invalid_argument(key + " " + why);
}

/// @param each  numbers of one body
void checkNumbers(const std::string& key, const std::vector<double>& numbers, std::size_t each) {
  if (numbers.size() % each != 0 || numbers.size() / each > kBodiesMost)
    refuse(key, "has " + std::to_string(numbers.size()) + " numbers; " + std::to_string(each) +
                    " for each body, 50 bodies at most");
  for (const double n : numbers)
    if (!(std::abs(n) <= kLargest)) refuse(key, "has a number beyond 1 m");
}

ToolBody boxOf(const double* n) {
  for (int axis = 0; axis < 3; ++axis)
    if (!(n[axis] < n[3 + axis]))
      refuse("tool_boxes", "has a box whose first corner is not the lesser one");
  return {{{n[0], n[1]}, {n[3], n[1]}, {n[3], n[4]}, {n[0], n[4]}}, n[2], n[5]};
}

ToolBody cylinderOf(const double* n) {
  constexpr int kCorners = 24;
  if (!(n[2] > 0.0 && n[3] < n[4]))
    refuse("tool_cylinders",
           "has a cylinder without radius, or whose first z is not the lesser one");
  const double around = n[2] / std::cos(EIGEN_PI / kCorners);  // holds all of the circle
  ToolBody body{{}, n[3], n[4]};
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2.0 * EIGEN_PI * i / kCorners;
    body.footprint.emplace_back(n[0] + around * std::cos(angle), n[1] + around * std::sin(angle));
  }
  return body;
}

bool isNear(const ToolBody& body, const Eigen::Vector2d& p, const double clearance) {
  if (contains(body.footprint, p)) return true;
  for (std::size_t i = 0; i < body.footprint.size(); ++i) {
    const Eigen::Vector2d& end = body.footprint[(i + 1) % body.footprint.size()];
    if (distanceToSegment(p, body.footprint[i], end) <= clearance) return true;
  }
  return false;
}

/// Points all over the footprint and its clearance, and along its border.
std::vector<Eigen::Vector2d> spread(const ToolBody& body, const double clearance) {
  Eigen::Vector2d low = body.footprint.front(), high = low;
  for (const Eigen::Vector2d& p : body.footprint) low = low.cwiseMin(p), high = high.cwiseMax(p);
  std::vector<Eigen::Vector2d> points;
  const auto across = [&](const int axis) {
    return 1 + static_cast<int>((high - low)[axis] / kStep);
  };
  low.array() -= clearance;
  high.array() += clearance;
  for (int i = 0; i <= across(0); ++i) {
    for (int k = 0; k <= across(1); ++k) {
      const Eigen::Vector2d p(low.x() + (high - low).x() * i / across(0),
                              low.y() + (high - low).y() * k / across(1));
      if (isNear(body, p, clearance)) points.push_back(p);
    }
  }
  for (std::size_t i = 0; i < body.footprint.size(); ++i) {
    const Eigen::Vector2d& a = body.footprint[i];
    const Eigen::Vector2d side = body.footprint[(i + 1) % body.footprint.size()] - a;
    const Eigen::Vector2d out = clearance * Eigen::Vector2d(side.y(), -side.x()).normalized();
    const int steps = 1 + static_cast<int>(side.norm() / kStep);
    for (int k = 0; k <= steps; ++k) points.push_back(a + side * k / steps + out);
  }
  return points;
}

bool isMaterial(const PartModel& part, const Eigen::Vector2d& p) {
  bool inside = false;
  for (const Loop& loop : part.file().drawing.loops)
    if (loop.kind != LoopKind::kPrint && contains(loop.points, p)) inside = !inside;
  return inside;
}

/// What of a line a + s * along, s in low .. high, lies between two heights of z.
struct Span {
  double low, high;
  bool isEmpty() const { return !(low <= high); }
};

Span between(const Eigen::Vector3d& a, const Eigen::Vector3d& along, Span s, double z0, double z1) {
  constexpr double kLevel = 1e-9;
  if (std::abs(along.z()) < kLevel) {
    if (a.z() < z0 || a.z() > z1) return {1.0, 0.0};
    return s;
  }
  const double first = (z0 - a.z()) / along.z(), second = (z1 - a.z()) / along.z();
  return {std::max(s.low, std::min(first, second)), std::min(s.high, std::max(first, second))};
}

}  // namespace

std::vector<ToolBody> toolBodies(const std::vector<double>& boxes,
                                 const std::vector<double>& cylinders) {
  constexpr std::size_t kBox = 6, kCylinder = 5;
  checkNumbers("tool_boxes", boxes, kBox);
  checkNumbers("tool_cylinders", cylinders, kCylinder);
  std::vector<ToolBody> bodies;
  for (std::size_t i = 0; i < boxes.size(); i += kBox) bodies.push_back(boxOf(&boxes[i]));
  for (std::size_t i = 0; i < cylinders.size(); i += kCylinder)
    bodies.push_back(cylinderOf(&cylinders[i]));
  return bodies;
}

bool touchesBin(const ToolWay& way, const PickBin& bin) {
  const Eigen::Isometry3d T_bin_pick = bin.T_bin_target * way.T_target_pick;
  const Eigen::Vector3d along = T_bin_pick.linear().col(2);
  const double least = std::numeric_limits<double>::lowest();
  for (const ToolBody& body : way.bodies) {
    for (const Eigen::Vector2d& corner : body.footprint) {
      const Eigen::Vector3d a = T_bin_pick * Eigen::Vector3d(corner.x(), corner.y(), 0.0);
      const Span inside =
          between(a, along, {body.low - way.approach, body.high}, least, bin.max.z());
      if (inside.isEmpty()) continue;
      for (const double s : {inside.low, inside.high}) {
        const Eigen::Vector3d p = a + s * along;
        const Eigen::Vector2d room = (p - bin.min).head<2>().cwiseMin((bin.max - p).head<2>());
        if (room.minCoeff() < way.clearance || p.z() < bin.min.z() - kFloorKnownTo) return true;
      }
    }
  }
  return false;
}

bool touchesPart(const ToolWay& way, const LyingPart& other) {
  const PartModel& part = *other.part;
  const Eigen::Isometry3d T_part_pick = other.T_target_part.inverse() * way.T_target_pick;
  const Eigen::Vector3d along = T_part_pick.linear().col(2);
  const double below = -std::max(part.thickness(), kSheet) - way.clearance;
  for (const ToolBody& body : way.bodies) {
    for (const Eigen::Vector2d& foot : spread(body, way.clearance)) {
      const Eigen::Vector3d a = T_part_pick * Eigen::Vector3d(foot.x(), foot.y(), 0.0);
      const Span within =
          between(a, along, {body.low - way.approach, body.high}, below, way.clearance);
      if (within.isEmpty()) continue;
      const Eigen::Vector2d from = (a + within.low * along).head<2>();
      const Eigen::Vector2d to = (a + within.high * along).head<2>();
      const double reach = part.radius() + (to - from).norm();
      if ((from - part.center()).norm() > reach) continue;
      const int steps = 1 + static_cast<int>((to - from).norm() / kStep);
      for (int i = 0; i <= steps; ++i)
        if (isMaterial(part, from + (to - from) * i / steps)) return true;
    }
  }
  return false;
}

bool touchesOwnPart(const std::vector<ToolBody>& bodies, const PartModel& part,
                    const Eigen::Isometry3d& T_part_pick) {
  constexpr double kPressed = 0.0015;  // metres; so far a cup is pressed on
  std::vector<ToolBody> beside;
  for (const ToolBody& body : bodies)
    if (body.high > kPressed) beside.push_back(body);
  const LyingPart own{std::shared_ptr<const PartModel>(std::shared_ptr<void>(), &part),
                      Eigen::Isometry3d::Identity()};
  return touchesPart({beside, T_part_pick, 0.0, 0.0}, own);
}

StrangeEdges::StrangeEdges(const cv::Mat& image, const Camera& camera,
                           const std::vector<Seen>& parts) {
  constexpr int kThreads = 1;
  const EdgeMap map = findEdges(image, camera, EdgesParams{}, kThreads);
  const Field& field = map.fields.front();
  focal_ = field.focal;
  cx_ = field.cx;
  cy_ = field.cy;
  edges_ = cv::Mat(field.height, field.width, CV_8U, cv::Scalar(0));
  for (int y = 0; y < field.height; ++y) {
    for (int x = 0; x < field.width; ++x) {
      const std::uint8_t* const distance = field.at(x, y);
      if (std::any_of(distance, distance + kDirections, [](const auto d) { return d == 0; }))
        edges_.at<std::uint8_t>(y, x) = 255;
    }
  }
  // Both faces' edges, their bevels and the shadows right beside them.
  constexpr double kBeside = 0.002;  // metres
  constexpr int kLeastPx = 3;
  for (const Seen& seen : parts) {
    const int reach = std::max(
        kLeastPx, static_cast<int>(kBeside * focal_ / seen.T_camera_part.translation().z()));
    for (const Loop& loop : seen.part->file().drawing.loops) {
      for (const double z : {0.0, -seen.part->thickness()}) {
        std::vector<cv::Point> line;
        for (const Eigen::Vector2d& p : loop.points) {
          const Eigen::Vector3d x = seen.T_camera_part * Eigen::Vector3d(p.x(), p.y(), z);
          line.emplace_back(static_cast<int>(std::lround(focal_ * x.x() / x.z() + cx_)),
                            static_cast<int>(std::lround(focal_ * x.y() / x.z() + cy_)));
        }
        cv::polylines(edges_, line, loop.closed, cv::Scalar(0), 2 * reach + 1);
      }
    }
  }
}

double StrangeEdges::below(const std::vector<ToolBody>& bodies,
                           const Eigen::Isometry3d& T_camera_pick) const {
  constexpr double kClear = 0.03;  // metres; what lies beside a part does not rise so far above it
  cv::Mat footprints(edges_.size(), CV_8U, cv::Scalar(0));
  for (const ToolBody& body : bodies) {
    if (body.high < -kClear) continue;  // a palm, say
    std::vector<cv::Point> seen, hull;
    for (const double z : {std::max(0.0, body.high), 0.0}) {
      for (const Eigen::Vector2d& corner : body.footprint) {
        const Eigen::Vector3d x = T_camera_pick * Eigen::Vector3d(corner.x(), corner.y(), z);
        if (x.z() <= 0.0) return 0.0;  // behind the camera nothing is seen
        seen.emplace_back(static_cast<int>(std::lround(focal_ * x.x() / x.z() + cx_)),
                          static_cast<int>(std::lround(focal_ * x.y() / x.z() + cy_)));
      }
    }
    cv::convexHull(seen, hull);
    cv::fillConvexPoly(footprints, hull, cv::Scalar(255));
  }
  const double pixel = T_camera_pick.translation().z() / focal_;  // metres
  return pixel * cv::countNonZero(footprints & edges_);
}

}  // namespace planar_bin_picking
