// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Comparisons that say by how much they failed.

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

#include <exception>
#include <string>
#include <type_traits>
#include <vector>

namespace planar_bin_picking {

/// Whether two poses agree: translation within `metres`, rotation within `radians`.
inline testing::AssertionResult isometryNear(const Eigen::Isometry3d& actual,
                                             const Eigen::Isometry3d& expected, double metres,
                                             double radians) {
  const double distance = (actual.translation() - expected.translation()).norm();
  const Eigen::Quaterniond a(actual.linear()), b(expected.linear());
  const double angle = a.angularDistance(b);
  auto result = distance <= metres && angle <= radians ? testing::AssertionSuccess()
                                                       : testing::AssertionFailure();
  constexpr double kDegreesPerRadian = 180.0 / 3.14159265358979323846;
  return result << "off by " << 1e3 * distance << " mm (allowed " << 1e3 * metres << ") and "
                << angle * kDegreesPerRadian << " deg (allowed " << radians * kDegreesPerRadian
                << ")";
}

/// Jacobian of `function` at x by central differences.
template <class Function, int kIn>
auto numericJacobian(const Function& function, const Eigen::Matrix<double, kIn, 1>& x,
                     double step) {
  using Out = std::decay_t<decltype(function(x))>;
  Eigen::Matrix<double, Out::RowsAtCompileTime, kIn> jacobian;
  for (int i = 0; i < kIn; ++i) {
    const Eigen::Matrix<double, kIn, 1> delta = step * Eigen::Matrix<double, kIn, 1>::Unit(i);
    jacobian.col(i) = (function(x + delta) - function(x - delta)) / (2.0 * step);
  }
  return jacobian;
}

/// Whether `call` throws a std::exception whose message holds all of `words`: the refusal must name
/// what is wrong.
template <class Call>
testing::AssertionResult refuses(const Call& call, const std::vector<std::string>& words) {
  try {
    call();
  } catch (const std::exception& e) {
    const std::string message = e.what();
    for (const std::string& word : words) {
      if (message.find(word) != std::string::npos) continue;
      return testing::AssertionFailure() << "\"" << word << "\" is not in: " << message;
    }
    return testing::AssertionSuccess() << message;
  }
  return testing::AssertionFailure() << "nothing was thrown";
}

}  // namespace planar_bin_picking
