// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What the tests of drawings share: they write a DXF file as text, read it and look at its loops.

#include "base/polygon.h"
#include "planar_bin_picking/drawing/drawing_file.h"
#include "support/dxf_writer.h"
#include "support/matchers.h"
#include "support/temp_dir.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kChordMm = 0.01;  // DrawingParams::chord_tolerance_mm

class DrawingTest : public testing::Test {
 protected:
  Drawing load(const DxfWriter& dxf, const DrawingParams& params = {}) {
    return loadDrawing(dir_.write("part.dxf", dxf.text()), params);
  }
  Drawing load(const std::string& text, const DrawingParams& params = {}) {
    return loadDrawing(dir_.write("part.dxf", text), params);
  }
  /// The error's words, besides the file's name.
  testing::AssertionResult refused(const std::string& text, std::vector<std::string> words) {
    words.push_back("part.dxf");
    const std::string path = dir_.write("part.dxf", text);
    return refuses([&] { loadDrawing(path); }, words);
  }
  testing::AssertionResult refused(const DxfWriter& dxf, const std::vector<std::string>& words) {
    return refused(dxf.text(), words);
  }
  testing::AssertionResult refused(const DxfWriter& dxf, const DrawingParams& params,
                                   const std::vector<std::string>& words) {
    return refuses([&] { load(dxf, params); }, words);
  }

  TempDir dir_;
};

inline std::vector<Eigen::Vector2d> mm(const Loop& loop) {
  std::vector<Eigen::Vector2d> points = loop.points;
  for (Eigen::Vector2d& p : points) p *= 1e3;
  return points;
}

inline Eigen::AlignedBox2d boxMm(const Loop& loop) {
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& p : mm(loop)) box.extend(p);
  return box;
}

inline testing::AssertionResult boxNear(const Loop& loop, double x0, double y0, double x1,
                                        double y1) {
  const Eigen::AlignedBox2d box = boxMm(loop);
  const double off = std::max((box.min() - Eigen::Vector2d(x0, y0)).cwiseAbs().maxCoeff(),
                              (box.max() - Eigen::Vector2d(x1, y1)).cwiseAbs().maxCoeff());
  // A curve's chords may cut its extreme point by the chord tolerance.
  auto result = off <= 1.01 * kChordMm ? testing::AssertionSuccess() : testing::AssertionFailure();
  return result << "box " << box.min().transpose() << " .. " << box.max().transpose();
}

/// Largest |implicit(p)| over points and chords of a loop, in mm.
template <class Implicit>
double worst(const Loop& loop, const Implicit& implicit) {
  const std::vector<Eigen::Vector2d> points = mm(loop);
  double largest = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d &a = points[i], &b = points[(i + 1) % points.size()];
    for (double s = 0.0; s < 1.0; s += 0.125)
      largest = std::max(largest, std::abs(implicit(a + s * (b - a))));
  }
  return largest;
}

inline double worstOffCircle(const Loop& loop, double x, double y, double radius) {
  return worst(
      loop, [&](const Eigen::Vector2d& p) { return (p - Eigen::Vector2d(x, y)).norm() - radius; });
}

/// In mm2, holes subtracted.
inline double areaMm2(const Drawing& drawing) {
  double area = 0.0;
  for (const Loop& loop : drawing.loops)
    area += loop.kind == LoopKind::kPrint ? 0.0 : 1e6 * signedArea(loop.points);
  return area;
}

/// Whether one of the texts holds all words.
inline bool says(const std::vector<std::string>& texts, const std::vector<std::string>& words) {
  return std::any_of(texts.begin(), texts.end(), [&](const std::string& text) {
    return std::all_of(words.begin(), words.end(), [&](const std::string& word) {
      return text.find(word) != std::string::npos;
    });
  });
}

inline int count(const Drawing& drawing, LoopKind kind) {
  return static_cast<int>(std::count_if(drawing.loops.begin(), drawing.loops.end(),
                                        [kind](const Loop& loop) { return loop.kind == kind; }));
}

}  // namespace planar_bin_picking
