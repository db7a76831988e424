// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

/// The same plate, however it is drawn: of which entities, in which unit, order and direction, in
/// which blocks, turned, moved or seen from behind.

#include "support/drawing_fixture.h"

#include <random>

namespace planar_bin_picking {
namespace {

constexpr double kWidth = 60, kHeight = 40, kRound = 6, kRadius = 8, kHoleX = 22, kHoleY = 17;

class AnyWay : public DrawingTest {
 protected:
  explicit AnyWay() : random_(11) {}
  int pick(int n) { return std::uniform_int_distribution<int>(0, n - 1)(random_); }
  double real(double a, double b) { return std::uniform_real_distribution<double>(a, b)(random_); }

  /// A section of the outline: straight, or an arc about a center.
  struct Side {
    Eigen::Vector2d a, b;
    double bulge = 0.0;
  };
  static std::vector<Side> outline() {
    const double r = kRound, quarter = std::tan(kPi / 8);
    return {{{0, 0}, {kWidth, 0}, 0.0},
            {{kWidth, 0}, {kWidth, kHeight - r}, 0.0},
            {{kWidth, kHeight - r}, {kWidth - r, kHeight}, quarter},
            {{kWidth - r, kHeight}, {0, kHeight}, 0.0},
            {{0, kHeight}, {0, 0}, 0.0}};
  }

  void drawSide(DxfWriter* dxf, const Side& side, double unit, const std::string& layer) {
    const bool back = pick(2) == 0;
    const Eigen::Vector2d a = (back ? side.b : side.a) * unit, b = (back ? side.a : side.b) * unit;
    if (side.bulge != 0.0 && pick(2) == 0) {
      dxf->arc((kWidth - kRound) * unit, (kHeight - kRound) * unit, kRound * unit, 0, 90, layer);
    } else if (side.bulge != 0.0 || pick(2) == 0) {
      dxf->polyline({{a.x(), a.y(), back ? -side.bulge : side.bulge}, {b.x(), b.y()}}, false,
                    layer);
    } else {
      dxf->line(a.x(), a.y(), b.x(), b.y(), layer);
    }
  }

  void drawOutline(DxfWriter* dxf, double unit, const std::string& layer) {
    std::vector<Side> sides = outline();
    std::shuffle(sides.begin(), sides.end(), random_);
    const bool twice = pick(4) == 0;
    for (const Side& side : sides) {
      drawSide(dxf, side, unit, layer);
      if (twice) drawSide(dxf, side, unit, layer);
    }
    if (pick(3) == 0) dxf->line(10 * unit, 0, 35 * unit, 0, layer);  // over a part of a side
  }

  void drawHole(DxfWriter* dxf, double unit, const std::string& layer) {
    const double x = kHoleX * unit, y = kHoleY * unit, r = kRadius * unit;
    switch (pick(5)) {
      case 0:
        dxf->circle(x, y, r, layer);
        break;
      case 1:
        dxf->arc(x, y, r, 30, 200, layer).arc(x, y, r, 200, 30, layer);
        break;
      case 2:
        dxf->polyline({{x - r, y, 1}, {x + r, y, 1}}, true, layer);
        break;
      case 3:
        dxf->entity("ELLIPSE", layer, {{10, x}, {20, y}, {11, 0}, {21, r}, {40, 1}});
        break;
      default:
        dxf->entity("CIRCLE", layer, {{10, -x}, {20, y}, {40, r}, {210, 0}, {220, 0}, {230, -1}});
    }
    if (pick(2) == 0)
      dxf->line(x - r / 2, y, x + r / 2, y, layer).line(x, y - r / 2, x, y + r / 2, layer);
  }

  std::mt19937 random_;
};

TEST_F(AnyWay, APlateIsDrawnItIsTheSame) {
  const std::vector<std::pair<int, double>> units = {{4, 1.0}, {1, 1 / 25.4}, {5, 0.1}, {6, 1e-3}};
  const double expected =
      kWidth * kHeight - kRound * kRound * (1 - kPi / 4) - kRadius * kRadius * kPi;
  for (int round = 0; round < 200; ++round) {
    const auto [code, unit] = units[static_cast<std::size_t>(pick(4))];
    DxfWriter dxf(code);
    const bool in_block = pick(2) == 0;
    const double turn = in_block ? real(-180, 180) : 0.0, scale = in_block ? real(0.5, 2.0) : 1.0;
    const bool mirrored = in_block && pick(2) == 0;
    const Eigen::Vector2d shift =
        in_block ? Eigen::Vector2d(real(-90, 90), real(-90, 90)) : Eigen::Vector2d::Zero().eval();
    const std::string layer = in_block ? "0" : "CUT";
    if (in_block) dxf.block("PART");
    if (pick(2) == 0) {
      drawOutline(&dxf, unit / scale, layer);
      drawHole(&dxf, unit / scale, layer);
    } else {
      drawHole(&dxf, unit / scale, layer);
      drawOutline(&dxf, unit / scale, layer);
    }
    if (in_block) {
      dxf.endBlock().insert("PART", shift.x() * unit, shift.y() * unit,
                            {{41, mirrored ? -scale : scale}, {42, scale}, {50, turn}}, "CUT");
    }
    const Drawing drawing = load(dxf);
    ASSERT_EQ(drawing.loops.size(), 2u) << round << "\n" << dxf.text();
    EXPECT_NEAR(areaMm2(drawing), expected, 0.6) << round;
    const Eigen::Affine2d placement = Eigen::Translation2d(shift) *
                                      Eigen::Rotation2Dd(turn * kPi / 180) *
                                      Eigen::Scaling(mirrored ? -1.0 : 1.0, 1.0);
    for (const Side& side : outline()) {
      const Eigen::Vector2d corner = placement * side.a;
      double nearest = 1e9;
      for (const Eigen::Vector2d& p : mm(drawing.loops[0]))
        nearest = std::min(nearest, (p - corner).norm());
      EXPECT_LT(nearest, 1e-6) << round;
    }
    const Eigen::Vector2d hole = placement * Eigen::Vector2d(kHoleX, kHoleY);
    EXPECT_LE(worstOffCircle(drawing.loops[1], hole.x(), hole.y(), kRadius), 1.01 * kChordMm)
        << round;
  }
}

}  // namespace
}  // namespace planar_bin_picking
