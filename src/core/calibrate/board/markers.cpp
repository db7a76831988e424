// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/board/markers.h"

#include <opencv2/core/version.hpp>
#if CV_VERSION_MAJOR > 4 || (CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR >= 7)
#define MARKERS_IN_OBJDETECT
#include <opencv2/objdetect/aruco_detector.hpp>
#else
#include <opencv2/aruco.hpp>
#endif

#include <array>
#include <stdexcept>
#include <string>
#include <utility>

namespace planar_bin_picking {
namespace {

namespace aruco = cv::aruco;

constexpr std::array<std::pair<const char*, int>, 21> kDictionaries{
    {{"DICT_4X4_50", aruco::DICT_4X4_50},
     {"DICT_4X4_100", aruco::DICT_4X4_100},
     {"DICT_4X4_250", aruco::DICT_4X4_250},
     {"DICT_4X4_1000", aruco::DICT_4X4_1000},
     {"DICT_5X5_50", aruco::DICT_5X5_50},
     {"DICT_5X5_100", aruco::DICT_5X5_100},
     {"DICT_5X5_250", aruco::DICT_5X5_250},
     {"DICT_5X5_1000", aruco::DICT_5X5_1000},
     {"DICT_6X6_50", aruco::DICT_6X6_50},
     {"DICT_6X6_100", aruco::DICT_6X6_100},
     {"DICT_6X6_250", aruco::DICT_6X6_250},
     {"DICT_6X6_1000", aruco::DICT_6X6_1000},
     {"DICT_7X7_50", aruco::DICT_7X7_50},
     {"DICT_7X7_100", aruco::DICT_7X7_100},
     {"DICT_7X7_250", aruco::DICT_7X7_250},
     {"DICT_7X7_1000", aruco::DICT_7X7_1000},
     {"DICT_ARUCO_ORIGINAL", aruco::DICT_ARUCO_ORIGINAL},
     {"DICT_APRILTAG_16h5", aruco::DICT_APRILTAG_16h5},
     {"DICT_APRILTAG_25h9", aruco::DICT_APRILTAG_25h9},
     {"DICT_APRILTAG_36h10", aruco::DICT_APRILTAG_36h10},
     {"DICT_APRILTAG_36h11", aruco::DICT_APRILTAG_36h11}}};

int numberOf(const std::string& dictionary) {
  for (const auto& [name, number] : kDictionaries) {
    if (dictionary == name) return number;
  }
  throw std::invalid_argument("board: dictionary is \"" + dictionary +
                              "\", must be one of OpenCV's, such as DICT_4X4_50 or "
                              "DICT_APRILTAG_36h11");
}

#ifdef MARKERS_IN_OBJDETECT
aruco::Dictionary predefined(int number) { return aruco::getPredefinedDictionary(number); }
const aruco::Dictionary& valueOf(const aruco::Dictionary& dictionary) { return dictionary; }
#else
cv::Ptr<aruco::Dictionary> predefined(int number) { return aruco::getPredefinedDictionary(number); }
const aruco::Dictionary& valueOf(const cv::Ptr<aruco::Dictionary>& dictionary) {
  return *dictionary;
}
#endif

}  // namespace

std::vector<MarkerSquare> markerSquares(const Board& board, bool first_is_dark) {
  std::vector<MarkerSquare> squares;
  for (int row = 0; row <= board.rows; ++row) {
    for (int col = 0; col <= board.cols; ++col) {
      if (((col + row) % 2 == 0) != first_is_dark) squares.push_back({col, row});
    }
  }
  return squares;
}

void checkDictionary(const Board& board) {
  const int needed = static_cast<int>(markerSquares(board, false).size());
  const auto dictionary = predefined(numberOf(board.dictionary));
  const int count = valueOf(dictionary).bytesList.rows;
  if (needed <= count) return;
  throw std::invalid_argument("board: dictionary " + board.dictionary + " has " +
                              std::to_string(count) + " markers, this board needs " +
                              std::to_string(needed) + "; take a larger one");
}

cv::Mat_<unsigned char> markerModules(const Board& board, int number) {
  checkDictionary(board);
  const auto dictionary = predefined(numberOf(board.dictionary));
  const int modules = valueOf(dictionary).markerSize + 2;
  cv::Mat image;
#ifdef MARKERS_IN_OBJDETECT
  aruco::generateImageMarker(dictionary, number, modules, image, 1);
#else
  aruco::drawMarker(dictionary, number, modules, image, 1);
#endif
  return image;
}

std::vector<SeenMarker> findMarkers(const cv::Mat& image, const Board& board) {
  checkDictionary(board);
  const auto dictionary = predefined(numberOf(board.dictionary));
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> numbers;
#ifdef MARKERS_IN_OBJDETECT
  aruco::ArucoDetector(dictionary).detectMarkers(image, corners, numbers);
#else
  aruco::detectMarkers(image, dictionary, corners, numbers);
#endif
  std::vector<SeenMarker> seen;
  for (std::size_t i = 0; i < numbers.size(); ++i) seen.push_back({numbers[i], corners[i]});
  return seen;
}

}  // namespace planar_bin_picking
