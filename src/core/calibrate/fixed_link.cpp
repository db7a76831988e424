// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/fixed_link.h"

#include "base/yaml_text.h"
#include "planar_bin_picking/base/se3.h"

#include <cmath>

namespace planar_bin_picking {
namespace {

/// A quaternion's coefficients are x y z w.
std::string joined(const Eigen::VectorXd& values) {
  std::string text;
  for (Eigen::Index i = 0; i < values.size(); ++i)
    text += (text.empty() ? "" : " ") + yamlNumber(values(i));
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

/// XML has no "--" in a comment, nor a "-" at its end.
std::string comment(const std::string& raw) {
  std::string out = "<!-- ";
  for (const char c : escaped(raw)) out += c == '-' && out.back() == '-' ? " -" : std::string(1, c);
  return out + " -->\n";
}

}  // namespace

std::string staticTransformLaunch(const FixedLink& link) {
  return comment(link.comment) +
         "<launch>\n  <node pkg=\"tf2_ros\" type=\"static_transform_publisher\" "
         "name=\"hand_eye_transform\"\n        args=\"" +
         joined(link.T_parent_child.translation()) + " " +
         joined(quaternionOf(link.T_parent_child.linear()).coeffs()) + " " + escaped(link.parent) +
         " " + escaped(link.child) + "\"/>\n</launch>\n";
}

std::string handEyeXacro(const FixedLink& link) {
  const Eigen::Matrix3d& R = link.T_parent_child.linear();
  const Eigen::Vector3d rpy(std::atan2(R(2, 1), R(2, 2)),
                            std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0))),
                            std::atan2(R(1, 0), R(0, 0)));
  const std::string parent = escaped(link.parent), child = escaped(link.child);
  return "<?xml version=\"1.0\"?>\n" + comment(link.comment) +
         "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\">\n  <link name=\"" + child +
         "\"/>\n  <joint name=\"hand_eye\" type=\"fixed\">\n    <parent link=\"" + parent +
         "\"/>\n    <child link=\"" + child + "\"/>\n    <origin xyz=\"" +
         joined(link.T_parent_child.translation()) + "\" rpy=\"" + joined(rpy) +
         "\"/>\n  </joint>\n</robot>\n";
}

}  // namespace planar_bin_picking
