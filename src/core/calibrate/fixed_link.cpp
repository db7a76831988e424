// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/fixed_link.h"

#include <cmath>
#include <iomanip>
#include <locale>
#include <sstream>
#include <vector>

namespace planar_bin_picking {
namespace {

using Values = std::vector<double>;

Values positionOf(const Eigen::Isometry3d& T) {
  const Eigen::Vector3d p = T.translation();
  return {p.x(), p.y(), p.z()};
}

/// x y z w, w not negative.
Values orientationOf(const Eigen::Isometry3d& T) {
  Eigen::Quaterniond q(T.linear());
  q.normalize();
  if (q.w() < 0.0) q.coeffs() *= -1.0;
  return {q.x(), q.y(), q.z(), q.w()};
}

std::string numberText(double value) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out << std::setprecision(10) << value;
  return out.str();
}

std::string joined(const Values& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : " ") + numberText(value);
  return text;
}

/// For XML: what a name must not hold there.
std::string escaped(const std::string& raw) {
  std::string out;
  for (const char c : raw) {
    const char* const safe = c == '&'   ? "&amp;"
                             : c == '<' ? "&lt;"
                             : c == '>' ? "&gt;"
                             : c == '"' ? "&quot;"
                                        : nullptr;
    out += safe != nullptr ? std::string(safe) : std::string(1, c);
  }
  return out;
}

}  // namespace

std::string staticTransformLaunch(const FixedLink& link) {
  return "<!-- " + escaped(link.comment) +
         " -->\n<launch>\n  <node pkg=\"tf2_ros\" type=\"static_transform_publisher\" "
         "name=\"hand_eye_transform\"\n        args=\"" +
         joined(positionOf(link.T_parent_child)) + " " +
         joined(orientationOf(link.T_parent_child)) + " " + escaped(link.parent) + " " +
         escaped(link.child) + "\"/>\n</launch>\n";
}

std::string handEyeXacro(const FixedLink& link) {
  const Eigen::Matrix3d& R = link.T_parent_child.linear();
  const Values rpy{std::atan2(R(2, 1), R(2, 2)), std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0))),
                   std::atan2(R(1, 0), R(0, 0))};
  const std::string parent = escaped(link.parent), child = escaped(link.child);
  return "<?xml version=\"1.0\"?>\n<!-- " + escaped(link.comment) +
         " -->\n<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\">\n  <link name=\"" + child +
         "\"/>\n  <joint name=\"hand_eye\" type=\"fixed\">\n    <parent link=\"" + parent +
         "\"/>\n    <child link=\"" + child + "\"/>\n    <origin xyz=\"" +
         joined(positionOf(link.T_parent_child)) + "\" rpy=\"" + joined(rpy) +
         "\"/>\n  </joint>\n</robot>\n";
}

}  // namespace planar_bin_picking
