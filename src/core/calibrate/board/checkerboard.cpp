// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/calibrate/board/checkerboard.h"

#include "planar_bin_picking/image/grey.h"

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace planar_bin_picking {
namespace {

cv::Mat checkedGrey(const cv::Mat& image) {
  if (image.empty() || image.channels() != 1 ||
      (image.depth() != CV_8U && image.depth() != CV_16U)) {
    throw std::invalid_argument("checkerboard: the image is empty or not grey of 8 or 16 bit");
  }
  return toEightBits(image);
}

/// The image made smaller by a whole number, and its corners back in full size. Corners are refined
/// in the full image anyway.
struct Shrunk {
  cv::Mat image;
  float factor = 1.0F;

  Shrunk(const cv::Mat& full, int largest) {
    const int whole = (std::max(full.cols, full.rows) + largest - 1) / largest;
    factor = static_cast<float>(whole);
    image = full;
    if (whole > 1) cv::resize(full, image, {}, 1.0 / whole, 1.0 / whole, cv::INTER_AREA);
  }
  /// Pixel (0, 0) is a pixel's centre in both.
  void restore(std::vector<cv::Point2f>* corners) const {
    for (cv::Point2f& p : *corners) {
      p = {(p.x + 0.5F) * factor - 0.5F, (p.y + 0.5F) * factor - 0.5F};
    }
  }
};

/// Larger images are made smaller before the sector-based detector searches them: it takes 0.2 s
/// then.
constexpr int kSectorSearch = 1400;

std::vector<cv::Point2f> sectorBased(const cv::Mat& image, const cv::Size& size) {
  const Shrunk small(image, kSectorSearch);
  std::vector<cv::Point2f> corners;
  if (!cv::findChessboardCornersSB(small.image, size, corners, cv::CALIB_CB_NORMALIZE_IMAGE)) {
    return {};
  }
  small.restore(&corners);
  return corners;
}

/// The classic detector takes a minute and more to give up where a board is partly visible in a
/// grainy image (87 s at 0.8 Mpx); in one of this size and smooth it takes about a second.
constexpr int kClassicSearch = 700;

std::vector<cv::Point2f> classicAsItIs(const cv::Mat& image, const cv::Size& size) {
  cv::Mat smooth;
  cv::GaussianBlur(image, smooth, {}, 1.0);
  std::vector<cv::Point2f> corners;
  const int flags =
      cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK;
  if (!cv::findChessboardCorners(smooth, size, corners, flags)) return {};
  return corners;
}

std::vector<cv::Point2f> classic(const cv::Mat& image, const cv::Size& size) {
  const Shrunk small(image, kClassicSearch);
  std::vector<cv::Point2f> corners = classicAsItIs(small.image, size);
  small.restore(&corners);
  return corners;
}

const cv::Point2f& at(const std::vector<cv::Point2f>& corners, const Board& board, int col,
                      int row) {
  return corners[static_cast<std::size_t>(row * board.cols + col)];
}

/// Length of the shortest side of a square in the image.
double shortestSide(const std::vector<cv::Point2f>& corners, const Board& board) {
  double shortest = 1e9;
  for (int r = 0; r < board.rows; ++r) {
    for (int c = 0; c < board.cols; ++c) {
      const cv::Point2f& p = at(corners, board, c, r);
      if (c > 0) shortest = std::min(shortest, cv::norm(p - at(corners, board, c - 1, r)));
      if (r > 0) shortest = std::min(shortest, cv::norm(p - at(corners, board, c, r - 1)));
    }
  }
  return shortest;
}

/// Right-handed as seen from the front: the columns' direction is the rows' turned clockwise.
void makeRightHanded(const Board& board, std::vector<cv::Point2f>* corners) {
  const cv::Point2f along = at(*corners, board, board.cols - 1, 0) - at(*corners, board, 0, 0);
  const cv::Point2f down = at(*corners, board, 0, board.rows - 1) - at(*corners, board, 0, 0);
  if (along.x * down.y - along.y * down.x > 0.0F) return;
  for (int r = 0; r < board.rows; ++r) {
    const auto begin = corners->begin() + r * board.cols;
    std::reverse(begin, begin + board.cols);
  }
}

float grey(const cv::Mat& image, const cv::Point2f& p) {
  cv::Mat pixel;
  cv::getRectSubPix(image, {3, 3}, p, pixel);
  return static_cast<float>(cv::mean(pixel)[0]);
}

/// Whether light and dark squares meet crosswise at every corner. A detector may take for corners
/// what the edge of the paper and the outermost squares form.
bool allCrossings(const cv::Mat& image, const Board& board,
                  const std::vector<cv::Point2f>& corners) {
  for (int r = 0; r < board.rows; ++r) {
    for (int c = 0; c < board.cols; ++c) {
      const int c0 = std::max(0, c - 1), c1 = std::min(board.cols - 1, c + 1);
      const int r0 = std::max(0, r - 1), r1 = std::min(board.rows - 1, r + 1);
      const cv::Point2f p = at(corners, board, c, r);
      const cv::Point2f u = (0.3F / static_cast<float>(c1 - c0)) *
                            (at(corners, board, c1, r) - at(corners, board, c0, r));
      const cv::Point2f v = (0.3F / static_cast<float>(r1 - r0)) *
                            (at(corners, board, c, r1) - at(corners, board, c, r0));
      const std::pair<float, float> one =
          std::minmax<float>(grey(image, p + u + v), grey(image, p - u - v));
      const std::pair<float, float> two =
          std::minmax<float>(grey(image, p + u - v), grey(image, p - u + v));
      if (!(one.first > two.second || two.first > one.second)) return false;
    }
  }
  return true;
}

/// For small boards in large images, which shrinking would lose: the classic detector in tiles of
/// the size that it searches fast. Half a tile is the largest board that surely lies within one.
std::vector<cv::Point2f> classicInTiles(const cv::Mat& image, const Board& board) {
  constexpr int kFineSearch = 3000, kStep = kClassicSearch / 2;
  const Shrunk fine(image, kFineSearch);
  const cv::Rect whole(0, 0, fine.image.cols, fine.image.rows);
  for (int y = 0; y == 0 || y + kStep < whole.height; y += kStep) {
    for (int x = 0; x == 0 || x + kStep < whole.width; x += kStep) {
      const cv::Rect tile = cv::Rect(x, y, kClassicSearch, kClassicSearch) & whole;
      auto corners = classicAsItIs(fine.image(tile), {board.cols, board.rows});
      for (cv::Point2f& p : corners) p += cv::Point2f(tile.tl());
      fine.restore(&corners);
      if (!corners.empty() && allCrossings(image, board, corners)) return corners;
    }
  }
  return {};
}

std::vector<cv::Point2f> search(const cv::Mat& image, const Board& board) {
  const cv::Size size(board.cols, board.rows);
  // The sector-based detector wants 3 corners a side.
  std::vector<cv::Point2f> corners;
  if (board.cols > 2 && board.rows > 2) corners = sectorBased(image, size);
  if (!corners.empty() && allCrossings(image, board, corners)) return corners;
  corners = classic(image, size);
  if (!corners.empty() && allCrossings(image, board, corners)) return corners;
  // The sector-based detector has searched all that is smaller as it is.
  if (std::max(image.cols, image.rows) <= kSectorSearch) return {};
  return classicInTiles(image, board);
}

/// How much darker the first square is than its neighbours.
float darknessOfFirst(const cv::Mat& image, const Board& board,
                      const std::vector<cv::Point2f>& corners) {
  float dark = 0.0F;
  for (int r = 0; r + 1 < board.rows; ++r) {
    for (int c = 0; c + 1 < board.cols; ++c) {
      const cv::Point2f centre =
          0.25F * (at(corners, board, c, r) + at(corners, board, c + 1, r) +
                   at(corners, board, c, r + 1) + at(corners, board, c + 1, r + 1));
      // Of an even number of squares in a row each has a partner of the other colour.
      dark += ((c + r) % 2 == 0 ? -1.0F : 1.0F) * (grey(image, centre) - 127.5F);
    }
  }
  return dark;
}

/// Turned by 90 degrees; for boards with as many columns as rows.
std::vector<cv::Point2f> quarterTurn(const Board& board, const std::vector<cv::Point2f>& corners) {
  std::vector<cv::Point2f> out(corners.size());
  for (int r = 0; r < board.rows; ++r) {
    for (int c = 0; c < board.cols; ++c) {
      out[static_cast<std::size_t>(r * board.cols + c)] = at(corners, board, board.cols - 1 - r, c);
    }
  }
  return out;
}

/// Where colours tell one end from the other, the first square is the dark one.
void startAtDark(const cv::Mat& image, const Board& board, std::vector<cv::Point2f>* corners) {
  if (darknessOfFirst(image, board, *corners) >= 0.0F) return;
  if ((board.cols + board.rows) % 2 != 0) {
    std::reverse(corners->begin(), corners->end());
  } else if (board.cols == board.rows && board.cols % 2 != 0) {
    *corners = quarterTurn(board, *corners);
  }
}

/// Spread of the blurred edge between two squares: contrast over its steepest slope, taken across
/// the middle of sides all over the board.
double edgeWidth(const cv::Mat& image, const Board& board, const std::vector<cv::Point2f>& corners,
                 double side) {
  const int reach = std::max(3, static_cast<int>(0.35 * side));
  std::vector<double> widths;
  for (int r = 0; r < board.rows; ++r) {
    for (int c = 0; c + 1 < board.cols; ++c) {
      const cv::Point2f a = at(corners, board, c, r), b = at(corners, board, c + 1, r);
      const cv::Point2f along = b - a, across(-along.y, along.x);
      const cv::Point2f step = across * (0.5F / static_cast<float>(cv::norm(across)));
      std::vector<float> profile;
      for (int k = -2 * reach; k <= 2 * reach; ++k) {
        cv::Mat pixel;
        cv::getRectSubPix(image, {1, 1}, 0.5F * (a + b) + static_cast<float>(k) * step, pixel,
                          CV_32F);
        profile.push_back(pixel.at<float>(0));
      }
      float steepest = 0.0F;
      for (std::size_t k = 2; k < profile.size(); ++k) {
        steepest = std::max(steepest, std::abs(profile[k] - profile[k - 2]));
      }
      const auto [low, high] = std::minmax_element(profile.begin(), profile.end());
      // A blurred step of height h and spread s has the slope h / (s * sqrt(2 pi)).
      if (steepest > 0.0F) widths.push_back((*high - *low) / steepest / 2.5066);
    }
  }
  const auto middle = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2);
  std::nth_element(widths.begin(), middle, widths.end());
  return widths.empty() ? 0.0 : *middle;
}

/// Half the side of the window in which corners are refined: as large as it can be without reaching
/// the neighbours, since every pixel of an edge counts.
int windowOf(double side) { return std::clamp(static_cast<int>(0.35 * side), 2, 25); }

/// Whether the next corners beyond the grid would be outside the picture.
bool touchesBorder(const cv::Size& image, const Board& grid,
                   const std::vector<cv::Point2f>& corners) {
  constexpr float kSquares = 1.2F;
  const auto is_outside = [&](const cv::Point2f& edge, const cv::Point2f& inner) {
    const cv::Point2f p = edge + kSquares * (edge - inner);
    return p.x < 0.0F || p.y < 0.0F || p.x > static_cast<float>(image.width - 1) ||
           p.y > static_cast<float>(image.height - 1);
  };
  const int last_col = grid.cols - 1, last_row = grid.rows - 1;
  for (int r = 0; r < grid.rows; ++r) {
    if (is_outside(at(corners, grid, 0, r), at(corners, grid, 1, r))) return true;
    if (is_outside(at(corners, grid, last_col, r), at(corners, grid, last_col - 1, r))) return true;
  }
  for (int c = 0; c < grid.cols; ++c) {
    if (is_outside(at(corners, grid, c, 0), at(corners, grid, c, 1))) return true;
    if (is_outside(at(corners, grid, c, last_row), at(corners, grid, c, last_row - 1))) return true;
  }
  return false;
}

enum class PartOfBoard { kNone, kInside, kCutOff };

/// Whether there is a checkerboard of any size. Older versions of OpenCV cannot tell: it may be,
/// then.
bool mayShowBoard(const cv::Mat& image, int least) {
#if CV_VERSION_MAJOR > 4 || (CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR >= 3)
  const Shrunk small(image, kSectorSearch);
  std::vector<cv::Point2f> corners;
  cv::Mat found;
  if (!cv::findChessboardCornersSB(small.image, {least, least}, corners,
                                   cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_LARGER, found)) {
    return false;
  }
  // It finds grids in mere grain, too.
  return allCrossings(small.image, {found.cols, found.rows, 1.0}, corners);
#else
  return !image.empty() && least > 0;
#endif
}

/// Whether some of a checkerboard is seen, and whether the picture's border cuts it off.
PartOfBoard partOfBoard(const cv::Mat& image, const Board& board) {
  constexpr int kLeast = 3;  // corners a side that the detector takes
  if (!mayShowBoard(image, kLeast)) return PartOfBoard::kNone;
  // Cut off at one side most often, which leaves whole columns, or whole rows.
  std::vector<cv::Size> sizes;
  for (int cols = board.cols - 1; cols >= kLeast; --cols) sizes.emplace_back(cols, board.rows);
  for (int rows = board.rows - 1; rows >= kLeast; --rows) sizes.emplace_back(board.cols, rows);
  for (int less = 1; std::min(board.cols, board.rows) - less >= kLeast; ++less) {
    sizes.emplace_back(board.cols - less, board.rows - less);
  }
  for (const cv::Size& size : sizes) {
    const std::vector<cv::Point2f> corners = sectorBased(image, size);
    if (corners.empty()) continue;
    if (touchesBorder(image.size(), {size.width, size.height, 1.0}, corners)) {
      return PartOfBoard::kCutOff;
    }
  }
  return PartOfBoard::kInside;
}

/// Nobody needs all pictures to see a miscount: some, evenly spread.
std::vector<cv::Mat> someOf(const std::vector<cv::Mat>& images) {
  std::vector<cv::Mat> some;
  const std::size_t step = std::max<std::size_t>(1, images.size() / 6);
  for (std::size_t i = 0; i < images.size(); i += step) some.push_back(checkedGrey(images[i]));
  return some;
}

}  // namespace

BoardObservation findBoard(const cv::Mat& image, const Board& board, double blur_max) {
  validate(board);
  const cv::Mat grey_image = checkedGrey(image);
  BoardObservation out;
  std::vector<cv::Point2f> corners = search(grey_image, board);
  if (corners.empty()) return out;
  makeRightHanded(board, &corners);
  startAtDark(grey_image, board, &corners);
  out.square_px = shortestSide(corners, board);
  const int window = windowOf(out.square_px);
  cv::cornerSubPix(grey_image, corners, {window, window}, {-1, -1},
                   {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 100, 1e-4});
  out.edge_px = edgeWidth(grey_image, board, corners, out.square_px);
  if (out.edge_px > blur_max) {
    out.status = BoardObservation::Status::kBlurred;
    return out;
  }
  out.status = BoardObservation::Status::kFound;
  for (const cv::Point2f& p : corners) out.corners.emplace_back(p.x, p.y);
  return out;
}

std::string findOtherBoard(const std::vector<cv::Mat>& images, const Board& board) {
  const std::vector<cv::Mat> some = someOf(images);
  // What one miscounts: one more or less, squares in place of inner corners.
  for (const auto& [dc, dr] : {std::pair(-1, -1),
                               {-1, 0},
                               {0, -1},
                               {1, 0},
                               {0, 1},
                               {1, 1},
                               {-1, 1},
                               {1, -1},
                               {-2, -2},
                               {2, 2}}) {
    const cv::Size size(board.cols + dc, board.rows + dr);
    if (size.width < 3 || size.height < 3) continue;
    // Of a board that is half out of view as many corners may be seen in each picture; but then the
    // next ones would be outside of all.
    std::size_t seen = 0, whole = 0;
    for (const cv::Mat& image : some) {
      const std::vector<cv::Point2f> corners = sectorBased(image, size);
      if (corners.empty()) continue;
      ++seen;
      const Board grid{size.width, size.height, 1.0};
      whole += touchesBorder(image.size(), grid, corners) ? 0 : 1;
    }
    if (whole == 0 || 2 * seen <= some.size()) continue;
    return std::to_string(size.width) + "x" + std::to_string(size.height);
  }
  return "";
}

std::string whyBoardIsMissing(const std::vector<cv::Mat>& images, const Board& board) {
  const std::string stated = std::to_string(board.cols) + "x" + std::to_string(board.rows);
  const std::string other = findOtherBoard(images, board);
  if (!other.empty()) {
    return "inner corners miscounted: most pictures show a board of " + other +
           " inner corners, stated are " + stated + "; set the board to that";
  }
  bool is_seen = false;
  for (const cv::Mat& image : someOf(images)) {
    const PartOfBoard part = partOfBoard(image, board);
    if (part == PartOfBoard::kCutOff) {
      return "board partly out of view: its edge leaves the picture; all " + stated +
             " inner corners must be seen: move the board to the middle, the camera farther away, "
             "or "
             "use a smaller board";
    }
    is_seen = is_seen || part == PartOfBoard::kInside;
  }
  if (is_seen) {
    return "part of a board: the pictures show fewer than " + stated +
           " inner corners of a checkerboard; count them, and check that nothing covers the board "
           "or "
           "shines on it";
  }
  return "no board: the pictures show no checkerboard; check that it is in view, lit and in focus, "
         "and "
         "that it has " +
         stated + " inner corners";
}

}  // namespace planar_bin_picking
