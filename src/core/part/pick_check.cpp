// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "part/pick_check.h"

#include "base/polygon.h"
#include "base/yaml_text.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace planar_bin_picking {
namespace {

/// A tool that is laid flat or over by rounding alone still counts as flat.
constexpr double kIntoLeast = 1e-6;
/// Of the thickness: deeper, a contact is on the far face, but for rounding.
constexpr double kThrough = 0.99;

const char* nameOf(Face face) { return face == Face::kFront ? "front" : "back"; }

/// Into the part from the face that is up: against the part's z from the front.
double inward(Face face) { return face == Face::kFront ? -1.0 : 1.0; }

bool appliesTo(const PickPose& pose, Face face) {
  return pose.face == FaceFilter::kAny ||
         (pose.face == FaceFilter::kFront) == (face == Face::kFront);
}

std::string inMm(const Eigen::Vector2d& p) {
  return "(" + yamlNumber(1e3 * p.x(), 1) + ", " + yamlNumber(1e3 * p.y(), 1) + ") mm";
}

/// Where the tool's axis meets the face.
Eigen::Vector2d contactOf(const PickPose& pose, double face_z) {
  const Eigen::Vector3d p = pose.T_part_pick.translation(), z = pose.T_part_pick.linear().col(2);
  return (p + (face_z - p.z()) / z.z() * z).head<2>();
}

double distanceTo(const Loop& loop, const Eigen::Vector2d& point) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < loop.points.size(); ++i) {
    nearest = std::min(nearest, distanceToSegment(point, loop.points[i],
                                                  loop.points[(i + 1) % loop.points.size()]));
  }
  return nearest;
}

/// What is wrong with a contact; empty where it is on the material with all of the tool.
std::string wrongContact(const Drawing& drawing, const Eigen::Vector2d& contact, double radius) {
  const Loop *crossed = nullptr, *around = nullptr;
  double nearest = std::numeric_limits<double>::infinity();
  for (const Loop& loop : drawing.loops) {
    if (loop.kind == LoopKind::kPrint) continue;
    const bool outer = loop.kind == LoopKind::kOuter;
    if (contains(loop.points, contact) != outer) around = &loop;
    const double distance = distanceTo(loop, contact);
    if (distance < nearest) {
      nearest = distance;
      crossed = &loop;
    }
  }
  if (around != nullptr) {
    return around->kind == LoopKind::kOuter ? "lies outside of the part's outline"
                                            : "lies over a hole";
  }
  if (crossed == nullptr || nearest >= radius) return "";
  return std::string("is ") + yamlNumber(1e3 * nearest, 1) + " mm from the part's " +
         (crossed->kind == LoopKind::kHole ? "hole" : "edge") + ", and the tool's radius is " +
         yamlNumber(1e3 * radius, 1) + " mm";
}

/// Metres by which the pose lies below the face that is up.
double depthOf(const PickPose& pose, Face face, double face_z) {
  return inward(face) * (pose.T_part_pick.translation().z() - face_z);
}

}  // namespace

bool isPickName(const std::string& name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](const unsigned char c) {
    return c > ' ' && c != 0x7F && c != '@' && c != '/';
  });
}

std::string wrongDirection(const PickPose& pose) {
  const Eigen::Vector3d z = pose.T_part_pick.linear().col(2);
  for (const Face face : {Face::kFront, Face::kBack}) {
    if (!appliesTo(pose, face) || z.z() * inward(face) > kIntoLeast) continue;
    const bool flat = std::abs(z.z()) <= kIntoLeast;
    std::string text = "its z is [" + yamlNumber(z.x(), 3) + ", " + yamlNumber(z.y(), 3) + ", " +
                       yamlNumber(z.z(), 3) +
                       "] in the part frame, which does not point into the part where its " +
                       nameOf(face) + " is up";
    const std::string rotation = face == Face::kFront ? "[180, 0, 0]" : "[0, 0, 0]";
    if (pose.face == FaceFilter::kAny && !flat) {
      const Face other = face == Face::kFront ? Face::kBack : Face::kFront;
      return text + "; say face: " + nameOf(other) + " if that is meant, or face: " + nameOf(face) +
             " and turn it, as rpy_deg: " + rotation + " does";
    }
    return text + "; turn it, as rpy_deg: " + rotation + " does" +
           (pose.face == FaceFilter::kAny ? ", and say face: front" : "");
  }
  return "";
}

std::vector<std::string> pickWarnings(const std::vector<PickPose>& poses, const PickTool& tool,
                                      const Drawing& drawing, double thickness) {
  std::vector<std::string> warnings;
  for (const PickPose& pose : poses) {
    const std::string wrong_direction = wrongDirection(pose);
    if (!wrong_direction.empty()) {
      warnings.push_back("pick pose " + pose.name + ": " + wrong_direction);
      continue;  // its axis need not meet the face at all
    }
    for (const Face face : {Face::kFront, Face::kBack}) {
      if (!appliesTo(pose, face)) continue;
      const double face_z = face == Face::kFront ? 0.0 : -thickness;
      const Eigen::Vector2d contact = contactOf(pose, face_z);
      const std::string what = "pick pose " + pose.name;
      const std::string wrong = wrongContact(drawing, contact, tool.radius.value_or(0.0));
      if (!wrong.empty())
        warnings.push_back(what + ": its contact at " + inMm(contact) + " " + wrong);
      // A gripper goes in between the faces; through the part nothing goes.
      const double depth = depthOf(pose, face, face_z);
      if (thickness > 0.0 && depth > kThrough * thickness) {
        warnings.push_back(what + ": lies " + yamlNumber(1e3 * depth, 1) + " mm below the " +
                           nameOf(face) + ", on the far face of the part or beyond it; the " +
                           nameOf(face) + " is at z = " + yamlNumber(1e3 * face_z, 1) + " mm");
      }
    }
  }
  return warnings;
}

}  // namespace planar_bin_picking
