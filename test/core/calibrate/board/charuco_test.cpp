// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

// Boards with markers: found whole and in part, described by a file, and printed.

#include "calibrate/board/charuco.h"
#include "calibrate/board/markers.h"
#include "planar_bin_picking/calibrate/board/board_file.h"
#include "planar_bin_picking/calibrate/board/board_print.h"
#include "planar_bin_picking/calibrate/board/find_board.h"
#include "planar_bin_picking/calibrate/board/missing_board.h"
#include "support/board_problem.h"
#include "support/matchers.h"
#include "support/temp_dir.h"

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include <sstream>

namespace planar_bin_picking {
namespace {

using Status = BoardObservation::Status;

sim::BoardCell charucoCell(int cols = 9, int rows = 6) {
  sim::BoardCell cell;
  cell.camera = {1000, 800, 1400.0, 1398.0, 505.0, 396.0, {-0.1, 0.06, -5e-4, 4e-4, 0.0}};
  cell.cols = cols;
  cell.rows = rows;
  sim::giveMarkers(&cell);
  return cell;
}

/// @param x, y  where the board's middle is, metres at the distance of the board
Eigen::Isometry3d at(const sim::BoardCell& cell, double x, double y, double yaw_deg = 20.0) {
  const Eigen::Matrix3d R = (Eigen::AngleAxisd(0.3, Eigen::Vector3d(0.6, 0.8, 0.0)) *
                             Eigen::AngleAxisd(yaw_deg * sim::kDegree, Eigen::Vector3d::UnitZ()))
                                .toRotationMatrix();
  return rigid(R, Eigen::Vector3d(x, y, 0.42) - R * cell.centre());
}

/// Largest distance of a corner from where it truly is.
double worst(const sim::BoardCell& cell, const Eigen::Isometry3d& T_camera_board,
             const BoardObservation& seen) {
  double most = 0.0;
  for (std::size_t i = 0; i < seen.corners.size(); ++i) {
    const std::size_t id = seen.ids.empty() ? i : seen.ids[i];
    const Eigen::Vector2d truth = project(cell.camera, T_camera_board * boardOf(cell).corner(id));
    most = std::max(most, (seen.corners[i] - truth).norm());
  }
  return most;
}

TEST(Charuco, IsFoundWhole) {
  for (const auto& [cols, rows] : {std::pair(9, 6), {5, 5}, {6, 9}}) {
    const sim::BoardCell cell = charucoCell(cols, rows);
    for (const double yaw : {20.0, 200.0}) {
      const auto T_camera_board = at(cell, 0.0, 0.0, yaw);
      const cv::Mat image = sim::takeBoardImage(cell, T_camera_board, 0.7, 2.0, 1);
      const BoardObservation seen = findBoard(image, boardOf(cell), 3.0);
      ASSERT_EQ(seen.status, Status::kFound) << cols << "x" << rows << " " << yaw;
      EXPECT_EQ(seen.corners.size(), boardOf(cell).size());
      EXPECT_TRUE(seen.ids.empty());
      EXPECT_LT(worst(cell, T_camera_board, seen), 0.25);
      EXPECT_NEAR(seen.edge_px, 0.8, 0.4);
    }
  }
}

TEST(Charuco, IsFoundInPart) {
  const sim::BoardCell cell = charucoCell();
  for (const auto& [x, y] : {std::pair(0.12, 0.0), {-0.1, 0.08}, {0.0, -0.11}}) {
    const auto T_camera_board = at(cell, x, y);
    const cv::Mat image = sim::takeBoardImage(cell, T_camera_board, 0.7, 2.0, 1);
    const BoardObservation seen = findBoard(image, boardOf(cell), 3.0);
    ASSERT_EQ(seen.status, Status::kFound) << x << " " << y;
    ASSERT_LT(seen.corners.size(), boardOf(cell).size());
    ASSERT_EQ(seen.corners.size(), seen.ids.size());
    EXPECT_GT(seen.corners.size(), 15u);
    EXPECT_LT(worst(cell, T_camera_board, seen), 0.25);
  }
}

TEST(Charuco, OldBoardsBeginWithALightSquare) {
  // As OpenCV up to 4.5 prints them: the same picture upside down, with the markers' numbers in the
  // other order.
  sim::BoardCell cell = charucoCell(8, 6);
  // Of 9 x 7 squares the light-first pattern has one marker more; its squares are drawn here.
  const Board board = boardOf(cell);
  const int px = 60, marker = 45, rim = (px - marker) / 2;
  cv::Mat image(7 * px + 80, 9 * px + 80, CV_8U, cv::Scalar(220));
  int number = 0;
  for (int row = 0; row < 7; ++row) {
    for (int col = 0; col < 9; ++col) {
      const cv::Rect square(40 + col * px, 40 + row * px, px, px);
      if ((col + row) % 2 != 0) {
        image(square).setTo(30);
        continue;
      }
      cv::Mat modules = markerModules(board, number++), large;
      cv::resize(modules, large, {marker, marker}, 0, 0, cv::INTER_NEAREST);
      large.copyTo(image({square.x + rim, square.y + rim, marker, marker}));
    }
  }
  cv::GaussianBlur(image, image, {}, 0.8);
  const BoardObservation seen = findBoard(image, board, 4.0);
  ASSERT_EQ(seen.status, Status::kFound);
  ASSERT_EQ(seen.corners.size(), 48u);
  EXPECT_LT((seen.corners[0] - Eigen::Vector2d(99.5, 99.5)).norm(), 0.1);
  EXPECT_LT((seen.corners[47] - Eigen::Vector2d(519.5, 399.5)).norm(), 0.1);
}

TEST(Charuco, TooLittleOfItIsNone) {
  const sim::BoardCell cell = charucoCell();
  const Board board = boardOf(cell);
  EXPECT_EQ(
      findBoard(sim::takeBoardImage(cell, at(cell, 0.2, 0.0), 0.7, 2.0, 1), board, 3.0).status,
      Status::kNotFound);
  const cv::Mat blurred = sim::takeBoardImage(cell, at(cell, 0.0, 0.0), 2.5, 2.0, 1);
  EXPECT_EQ(findBoard(blurred, board, 1.5).status, Status::kBlurred);
  Board other = board;
  other.dictionary = "DICT_6X6_250";
  const cv::Mat image = sim::takeBoardImage(cell, at(cell, 0.0, 0.0), 0.7, 2.0, 1);
  EXPECT_EQ(findBoard(image, other, 3.0).status, Status::kNotFound);
  const std::string why = whyBoardIsMissing({image}, other);
  EXPECT_NE(why.find("DICT_6X6_250"), std::string::npos) << why;
  EXPECT_NE(why.find("no board"), std::string::npos) << why;
  const cv::Mat part = sim::takeBoardImage(cell, at(cell, 0.17, 0.0), 0.7, 2.0, 1);
  EXPECT_NE(whyBoardIsMissing({part}, board).find("too little"), std::string::npos);
  const cv::Mat plain(400, 400, CV_8U, cv::Scalar(128));
  EXPECT_EQ(findBoard(plain, board, 3.0).status, Status::kNotFound);
}

TEST(Charuco, CornersInARowAreNotEnough) {
  const Board board{9, 6, 0.02};
  EXPECT_TRUE(areEnough(board, {0, 1, 2, 9, 10, 11}));
  EXPECT_FALSE(areEnough(board, {0, 1, 2, 9, 10}));
  EXPECT_FALSE(areEnough(board, {0, 1, 2, 3, 4, 5, 6, 7}));
  EXPECT_FALSE(areEnough(board, {0, 9, 10, 19, 20, 29}));  // along the diagonal
}

TEST(Charuco, EverythingWrongInAFileIsNamed) {
  const TempDir dir;
  const auto refused = [&](const std::string& text, const std::vector<std::string>& words) {
    dir.write("board.yaml", text);
    return refuses([&] { loadBoard(dir.path("board.yaml")); }, words);
  };
  const std::string charuco = "kind: charuco\ncorners: 9x6\nsquare: 0.02\n";
  dir.write("board.yaml", charuco + "marker: 0.015\ndictionary: DICT_5X5_50\n");
  const Board board = loadBoard(dir.path("board.yaml"));
  EXPECT_EQ(board.kind, Board::Kind::kCharuco);
  EXPECT_EQ(board.cols, 9);
  EXPECT_DOUBLE_EQ(board.marker, 0.015);
  EXPECT_TRUE(
      refused("kind: circles\ncorners: 9x6\nsquare: 0.02\n", {"kind", "circles", "charuco"}));
  EXPECT_TRUE(refused(charuco + "dictionary: DICT_5X5_50\n", {"marker", "metres"}));
  EXPECT_TRUE(refused(charuco + "marker: 0.015\n", {"dictionary", "DICT_4X4_50"}));
  EXPECT_TRUE(refused(charuco + "marker: 0.019\ndictionary: DICT_5X5_50\n", {"marker", "0.9"}));
  EXPECT_TRUE(refused(charuco + "marker: 0.015\ndictionary: ARUCO\n", {"dictionary", "ARUCO"}));
  EXPECT_TRUE(
      refused("kind: charuco\ncorners: 12x9\nsquare: 0.02\nmarker: 0.015\n"
              "dictionary: DICT_5X5_50\n",
              {"50 markers", "needs 65"}));
  EXPECT_TRUE(refused("kind: checkerboard\ncorners: 9x6\nsquare: 0.02\nmarker: 0.01\n",
                      {"marker", "left out"}));
  EXPECT_TRUE(refused("kind: checkerboard\ncorners: 9\nsquare: 0.02\n",
                      {"board.yaml: corners is \"9\"", "COLSxROWS"}));
  EXPECT_TRUE(refused(charuco + "size: 3\n", {"unknown key", "size"}));
}

/// The page as a printer puts it on paper, at so many pixels a millimetre.
cv::Mat printed(const std::string& pdf, double px_per_mm) {
  std::istringstream lines(pdf);
  std::string line;
  cv::Mat image;
  int level = 0;
  for (double height = 0.0; std::getline(lines, line);) {
    std::istringstream in(line);
    const auto box = line.find("/MediaBox [0 0 ");
    if (box != std::string::npos) {
      std::istringstream size(line.substr(box + 15));
      double width = 0.0;
      size >> width >> height;
      const double scale = px_per_mm * 25.4 / 72.0;
      image = cv::Mat(cvRound(scale * height), cvRound(scale * width), CV_8U, cv::Scalar(255));
    }
    double x = 0.0, y = 0.0, w = 0.0, h = 0.0;
    std::string word;
    if (line.size() == 3 && line.substr(1) == " g") level = line[0] == '1' ? 255 : 0;
    if (!(in >> x >> y >> w >> h >> word) || word != "re") continue;
    const int left = cvRound(px_per_mm * x), right = cvRound(px_per_mm * (x + w));
    const int top = image.rows - cvRound(px_per_mm * (y + h));
    const int bottom = image.rows - cvRound(px_per_mm * y);
    image({left, top, std::max(1, right - left), std::max(1, bottom - top)}).setTo(level);
  }
  return image;
}

TEST(BoardPdf, IsFoundAtTrueSize) {
  Board board{9, 6, 0.02};
  for (const bool has_markers : {false, true}) {
    if (has_markers) {
      board.kind = Board::Kind::kCharuco;
      board.marker = 0.015;
      board.dictionary = "DICT_4X4_50";
    }
    const std::string pdf = boardPdf(board);
    constexpr double kScale = 4.0;  // pixels a millimetre
    const cv::Mat page = printed(pdf, kScale);
    EXPECT_EQ(page.cols, 297 * 4) << "A4, lengthwise";
    EXPECT_EQ(page.rows, 210 * 4);
    cv::Mat picture;
    cv::GaussianBlur(page, picture, {}, 0.8);
    const BoardObservation seen = findBoard(picture, board, 4.0);
    ASSERT_EQ(seen.status, Status::kFound) << has_markers;
    ASSERT_EQ(seen.corners.size(), 54u);
    EXPECT_NEAR((seen.corners[8] - seen.corners[0]).norm(), kScale * 160.0, 0.2);
    EXPECT_NEAR((seen.corners[45] - seen.corners[0]).norm(), kScale * 100.0, 0.2);
  }
}

TEST(BoardPdf, HasRulersOfWholeCentimetresAndSaysWhatItIs) {
  Board board{9, 6, 0.02};
  board.kind = Board::Kind::kCharuco;
  board.marker = 0.015;
  board.dictionary = "DICT_4X4_50";
  const std::string pdf = boardPdf(board);
  for (const char* word : {"charuco, 9x6 inner corners", "square 20 mm", "marker 15 mm",
                           "DICT_4X4_50", "100 mm long", "/PrintScaling /None", "%PDF-1.4"}) {
    EXPECT_NE(pdf.find(word), std::string::npos) << word;
  }
  // The two long bars: 100 mm along x and along y.
  EXPECT_NE(pdf.find(" 100.0000 0.2000 re f"), std::string::npos);
  EXPECT_NE(pdf.find(" 0.2000 100.0000 re f"), std::string::npos);
  // Each entry of the table leads to its object.
  const std::size_t table = pdf.find("0000000000 65535 f");
  for (int i = 1; i <= 5; ++i) {
    const auto at = std::stoul(pdf.substr(table + 20 * static_cast<std::size_t>(i), 10));
    EXPECT_EQ(pdf.substr(at, 7), std::to_string(i) + " 0 obj");
  }
}

TEST(BoardPdf, LargeBoardsGetLargePaper) {
  EXPECT_EQ(printed(boardPdf({20, 13, 0.018}), 1.0).cols, 420);
  const cv::Mat own = printed(boardPdf({9, 6, 0.2}), 1.0);
  EXPECT_EQ(own.cols, 2040);
  EXPECT_EQ(own.rows, 1440);
}

}  // namespace
}  // namespace planar_bin_picking
