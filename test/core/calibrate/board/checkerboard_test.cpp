// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/calibrate/board/find_board.h"
#include "planar_bin_picking/calibrate/board/missing_board.h"
#include "sim/board_cell.h"
#include "support/board_problem.h"
#include "support/matchers.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <string>

namespace planar_bin_picking {
namespace {

sim::BoardCell smallCell(int cols, int rows) {
  sim::BoardCell cell;
  cell.camera = {1000, 800, 1400.0, 1398.0, 505.0, 396.0, {-0.1, 0.06, -5e-4, 4e-4, 0.0}};
  cell.cols = cols;
  cell.rows = rows;
  cell.corner_px = 0.0;
  return cell;
}

Eigen::Isometry3d tilted(const sim::BoardCell& cell, double yaw_deg) {
  const Eigen::Matrix3d R = (Eigen::AngleAxisd(0.35, Eigen::Vector3d(0.6, 0.8, 0.0)) *
                             Eigen::AngleAxisd(yaw_deg * sim::kDegree, Eigen::Vector3d::UnitZ()))
                                .toRotationMatrix();
  return rigid(R, Eigen::Vector3d(0.01, -0.01, 0.5) - R * cell.centre());
}

/// RMS distance to the true corners in the ordering that fits best; which one, too.
std::pair<double, std::size_t> error(const sim::BoardCell& cell,
                                     const Eigen::Isometry3d& T_camera_board,
                                     const BoardObservation& observation) {
  std::mt19937 random(1);
  std::vector<Eigen::Vector2d> truth;
  sim::seeCorners(cell, T_camera_board, &random, &truth);
  std::pair<double, std::size_t> best(1e9, 0);
  const auto all = orderings(boardOf(cell));
  for (std::size_t k = 0; k < all.size(); ++k) {
    double sum = 0.0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      sum += (observation.corners[all[k][i]] - truth[i]).squaredNorm();
    }
    best = std::min(best, {std::sqrt(sum / static_cast<double>(truth.size())), k});
  }
  return best;
}

TEST(Checkerboard, IsFoundInAnyTurn) {
  for (const auto& [cols, rows] :
       {std::pair(9, 6), {6, 9}, {8, 6}, {7, 5}, {5, 5}, {6, 6}, {3, 4}}) {
    const sim::BoardCell cell = smallCell(cols, rows);
    for (const double yaw : {70.0, 230.0}) {
      const auto T_camera_board = tilted(cell, yaw);
      const cv::Mat image = sim::takeBoardImage(cell, T_camera_board, 0.7, 2.0, 1);
      const BoardObservation observation = findBoard(image, boardOf(cell), 3.0);
      ASSERT_EQ(observation.status, BoardObservation::Status::kFound)
          << cols << "x" << rows << " " << yaw;
      const auto [rms, ordering] = error(cell, T_camera_board, observation);
      // Noise of 2 grey levels at a contrast of 190.
      EXPECT_LT(rms, 0.08) << cols << "x" << rows << " " << yaw;
      if (orderings(boardOf(cell)).size() == 1) {
        EXPECT_EQ(ordering, 0u);
      }
    }
  }
}

TEST(Checkerboard, OrderingsOfASquareWithOddCornersIsTwo) {
  EXPECT_EQ(orderings({5, 5, 0.02}).size(), 2u);
  EXPECT_EQ(orderings({6, 6, 0.02}).size(), 4u);
  EXPECT_EQ(orderings({9, 6, 0.02}).size(), 1u);
  EXPECT_EQ(orderings({8, 6, 0.02}).size(), 2u);
}

TEST(Checkerboard, SixteenBitsAreAsGood) {
  const sim::BoardCell cell = smallCell(9, 6);
  cv::Mat image = sim::takeBoardImage(cell, tilted(cell, 10.0), 0.7, 1.0, 1), deep;
  image.convertTo(deep, CV_16U, 16.0);
  const BoardObservation observation = findBoard(deep, boardOf(cell), 3.0);
  ASSERT_EQ(observation.status, BoardObservation::Status::kFound);
  EXPECT_LT(error(cell, tilted(cell, 10.0), observation).first, 0.08);
}

TEST(Checkerboard, MeasuresBlur) {
  const sim::BoardCell cell = smallCell(9, 6);
  for (const double blur : {0.7, 1.5, 3.0}) {
    const cv::Mat image = sim::takeBoardImage(cell, tilted(cell, 20.0), blur, 1.0, 1);
    const BoardObservation observation = findBoard(image, boardOf(cell), 2.2);
    EXPECT_NEAR(observation.edge_px, blur, 0.3 + 0.15 * blur);
    EXPECT_EQ(observation.status,
              blur > 2.2 ? BoardObservation::Status::kBlurred : BoardObservation::Status::kFound);
    EXPECT_EQ(observation.corners.empty(), blur > 2.2);
  }
}

TEST(Checkerboard, IsNotFoundWhereThereIsNone) {
  const cv::Mat grey(800, 1000, CV_8U, cv::Scalar(90));
  EXPECT_EQ(findBoard(grey, {9, 6, 0.02}, 3.0).status, BoardObservation::Status::kNotFound);
  const sim::BoardCell cell = smallCell(9, 6);
  Eigen::Isometry3d half_out = tilted(cell, 0.0);
  half_out.translation().x() += 0.16;
  const cv::Mat image = sim::takeBoardImage(cell, half_out, 0.7, 2.0, 1);
  EXPECT_EQ(findBoard(image, boardOf(cell), 3.0).status, BoardObservation::Status::kNotFound);
}

TEST(Checkerboard, NamesTheBoardThatIsThere) {
  const sim::BoardCell cell = smallCell(9, 6);
  const std::vector<cv::Mat> images{sim::takeBoardImage(cell, tilted(cell, 0.0), 0.7, 2.0, 1),
                                    sim::takeBoardImage(cell, tilted(cell, 40.0), 0.7, 2.0, 2)};
  EXPECT_EQ(findOtherBoard(images, {10, 7, 0.02}), "9x6");
  EXPECT_EQ(findOtherBoard(images, {9, 7, 0.02}), "9x6");
  EXPECT_EQ(findOtherBoard({cv::Mat(800, 1000, CV_8U, cv::Scalar(90))}, {9, 7, 0.02}), "");
}

TEST(Checkerboard, SaysWhyItIsMissing) {
  const sim::BoardCell cell = smallCell(9, 6);
  const auto seen = [&](double right) {
    Eigen::Isometry3d T_camera_board = tilted(cell, 0.0);
    T_camera_board.translation().x() += right;
    return sim::takeBoardImage(cell, T_camera_board, 0.7, 2.0, 1);
  };
  const auto why = [](const cv::Mat& image, const Board& board) {
    return whyBoardIsMissing({image}, board);
  };
  EXPECT_EQ(why(seen(0.0), {10, 7, 0.02}).find("inner corners miscounted"), 0u);
  EXPECT_NE(why(seen(0.0), {10, 7, 0.02}).find("9x6"), std::string::npos);
  // Half of it is seen; it is no board of fewer corners.
  EXPECT_EQ(why(seen(0.16), {9, 6, 0.02}).find("board partly out of view"), 0u);
  EXPECT_EQ(findOtherBoard({seen(0.16)}, {9, 6, 0.02}), "");
  EXPECT_EQ(why(seen(2.0), {9, 6, 0.02}).find("no board"), 0u);
}

// Neither whole columns nor whole rows are left of it.
TEST(Checkerboard, CutOffAslantIsNamed) {
  const sim::BoardCell cell = smallCell(9, 6);
  for (const double degrees : {25.0, 45.0, 70.0, 115.0}) {
    Eigen::Isometry3d T_camera_board = tilted(cell, degrees);
    T_camera_board.translation().x() += 0.16;
    const cv::Mat image = sim::takeBoardImage(cell, T_camera_board, 0.7, 2.0, 1);
    EXPECT_EQ(whyBoardIsMissing({image}, {9, 6, 0.02}).find("board partly out of view"), 0u)
        << degrees << ": " << whyBoardIsMissing({image}, {9, 6, 0.02});
  }
}

TEST(Checkerboard, CoveredIsNotOutOfView) {
  const sim::BoardCell cell = smallCell(9, 6);
  cv::Mat image = sim::takeBoardImage(cell, tilted(cell, 0.0), 0.7, 2.0, 1);
  const cv::Point middle(image.cols / 2, image.rows / 2);
  cv::circle(image, middle, image.rows / 10, cv::Scalar(90), cv::FILLED);
  EXPECT_EQ(whyBoardIsMissing({image}, {9, 6, 0.02}).find("part of a board"), 0u)
      << whyBoardIsMissing({image}, {9, 6, 0.02});
}

// Their edges and holes have crossings, some of which look joined.
TEST(Checkerboard, PartsInABinAreNone) {
  const std::string scene = std::string(PACKAGE_DIR) + "/test/data/bin_bracket_00/image.png";
  const cv::Mat image = cv::imread(scene, cv::IMREAD_GRAYSCALE);
  ASSERT_FALSE(image.empty());
  EXPECT_EQ(whyBoardIsMissing({image}, {9, 6, 0.02}).find("no board"), 0u)
      << whyBoardIsMissing({image}, {9, 6, 0.02});
}

// Shrunk to the size that is searched first, its squares have 4 pixels.
TEST(Checkerboard, IsFoundWhereItIsSmallInALargePicture) {
  sim::BoardCell cell = smallCell(4, 3);
  cell.camera = {2800, 2000, 1400.0, 1398.0, 1400.0, 1000.0, {0.0, 0.0, 0.0, 0.0, 0.0}};
  Eigen::Isometry3d T_camera_board = tilted(cell, 25.0);
  T_camera_board.translation() *= 5.0;
  const cv::Mat image = sim::takeBoardImage(cell, T_camera_board, 0.6, 1.0, 1);
  EXPECT_EQ(findBoard(image, boardOf(cell), 3.0).status, BoardObservation::Status::kFound);
}

TEST(Checkerboard, RefusesBadInput) {
  EXPECT_TRUE(refuses([] { parseBoard("9 by 6", 0.02); }, {"9 by 6", "9x6"}));
  EXPECT_TRUE(refuses([] { parseBoard("9x6x2", 0.02); }, {"9x6x2"}));
  EXPECT_TRUE(refuses([] { parseBoard("9x1", 0.02); }, {"rows", "1", "inner corners"}));
  EXPECT_TRUE(refuses([] { parseBoard("2x9", 0.02); }, {"cols is 2", "3 .. 100 inner corners"}));
  EXPECT_EQ(parseBoard("3x3", 0.02).size(), 9u);
  EXPECT_TRUE(refuses([] { parseBoard("9x6", 0.0); }, {"square", "metres"}));
  EXPECT_EQ(parseBoard("9x6", 0.02).cols, 9);
  EXPECT_TRUE(refuses([] { findBoard(cv::Mat(), {9, 6, 0.02}, 3.0); }, {"empty"}));
  EXPECT_TRUE(refuses([] { findBoard(cv::Mat(9, 9, CV_8UC3), {9, 6, 0.02}, 3.0); }, {"grey"}));
}

}  // namespace
}  // namespace planar_bin_picking
