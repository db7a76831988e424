// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "image/edges.h"

#include "base/parallel.h"
#include "base/simd.h"
#include "image/noise.h"
#include "image/scharr.h"
#include "image/texture.h"
#include "planar_bin_picking/image/grey.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace planar_bin_picking {
namespace {

/// Scharr's response to white noise of sigma s has sigma s times the root of this per component: of
/// 2 (3^2 + 10^2 + 3^2).
constexpr double kScharrVariance = 236.0;
/// Slope beyond which a gradient counts as diagonal: the tangent of 22 degrees, halfway.
constexpr int kSlopeAbove = 2, kSlopeBelow = 5;
/// Pixels along the tangent at which a contour has to go on.
constexpr int kAhead = 2;
/// Pixels of the image's border without edgels: kAhead, its neighbours and the gradient's.
constexpr int kBorder = 4;
/// Pixels from one node of the undistortion's grid to the next; lenses bend little within.
constexpr int kGridStep = 16;
constexpr int kBand = 64;  // rows that one thread takes at a time

/// Shrunken 8-bit image and the whole number by which it was shrunk.
struct Base {
  cv::Mat grey;
  int shrink = 1;
};

Base shrinkImage(const cv::Mat& image, int shrink) {
  if (shrink == 1) return {image, 1};
  // Only whole blocks, so that base pixel (x, y) is the mean of exactly shrink x shrink pixels.
  const cv::Rect whole(0, 0, image.cols / shrink * shrink, image.rows / shrink * shrink);
  Base base{{}, shrink};
  cv::resize(image(whole), base.grey, {whole.width / shrink, whole.height / shrink}, 0, 0,
             cv::INTER_AREA);
  return base;
}

/// By how much the image is shrunk to be of about the size that the parameters say.
int usualShrink(const cv::Mat& image, const EdgesParams& params) {
  return std::max(
      1, static_cast<int>(std::lround(std::sqrt(image.total() / (params.megapixels * 1e6)))));
}

/// What is found in the base image.
struct Marks {
  cv::Mat_<std::uint8_t> direction;  ///< bin + 1 of each edgel, 0 elsewhere
  cv::Mat_<std::uint8_t> is_faint;   ///< whether it may be texture
};

}  // namespace

/// Gradients along x and y and their squared length at columns 1 to w - 2 of the middle of three
/// rows.
PBP_SIMD
static void gradients(const std::uint8_t* above, const std::uint8_t* row, const std::uint8_t* below,
                      int w, int* __restrict dx, int* __restrict dy, int* __restrict squared) {
  for (int x = 1; x < w - 1; ++x) {
    const Scharr gradient(above, row, below, x);
    dx[x] = gradient.h;
    dy[x] = gradient.v;
    squared[x] = gradient.squared();
  }
}

namespace {

/// Ridge of the Scharr gradient above the noise, in rows y0 to y1.
void markEdgels(const cv::Mat& grey, const std::array<float, 256>& noise, const Texture& texture,
                const EdgesParams& params, int y0, int y1, Marks* marks) {
  const int w = grey.cols;
  const auto faintest = static_cast<float>(params.texture_factor);
  std::array<int, 256> threshold{};
  for (int g = 0; g < 256; ++g) {
    threshold[g] =
        static_cast<int>(std::pow(params.noise_factor * noise[g] * std::sqrt(kScharrVariance), 2));
  }
  // Three rolling rows of gradients.
  std::vector<int> buffer(9 * w, 0);
  int* gx[3] = {buffer.data(), buffer.data() + w, buffer.data() + 2 * w};
  int* gy[3] = {gx[2] + w, gx[2] + 2 * w, gx[2] + 3 * w};
  int* mag[3] = {gy[2] + w, gy[2] + 2 * w, gy[2] + 3 * w};
  const auto gradient = [&](int y, int slot) {
    if (y < 1 || y + 1 >= grey.rows) {
      std::fill(mag[slot], mag[slot] + w, 0);
      return;
    }
    const auto *a = grey.ptr<std::uint8_t>(y - 1), *b = grey.ptr<std::uint8_t>(y),
               *c = grey.ptr<std::uint8_t>(y + 1);
    gradients(a, b, c, w, gx[slot], gy[slot], mag[slot]);
  };
  gradient(y0 - 1, 0);
  gradient(y0, 1);
  for (int y = y0; y < y1; ++y) {
    const int up = (y - y0) % 3, here = (y - y0 + 1) % 3, down = (y - y0 + 2) % 3;
    gradient(y + 1, down);
    const auto* level = grey.ptr<std::uint8_t>(y);
    auto *out = marks->direction.ptr(y), *is_faint = marks->is_faint.ptr(y);
    for (int x = 2; x < w - 2; ++x) {
      const int m = mag[here][x];
      if (m < threshold[level[x]]) continue;
      const int h = gx[here][x], v = gy[here][x], ah = std::abs(h), av = std::abs(v);
      int before, after;
      if (kSlopeBelow * av < kSlopeAbove * ah) {
        before = mag[here][x - 1], after = mag[here][x + 1];
      } else if (kSlopeBelow * ah < kSlopeAbove * av) {
        before = mag[up][x], after = mag[down][x];
      } else if ((h > 0) == (v > 0)) {
        before = mag[up][x - 1], after = mag[down][x + 1];
      } else {
        before = mag[up][x + 1], after = mag[down][x - 1];
      }
      if (m > before && m >= after) {
        out[x] = static_cast<std::uint8_t>(1 + directionBin<double>(h, v));
        const float least = faintest * texture.at(x, y);
        is_faint[x] = static_cast<float>(m) < least * least;
      }
    }
  }
}

/// What the neighbours along a contour look like, by direction bin.
struct Continuation {
  std::array<std::array<int, 2>, kDirections> along;                           // kAhead pixels on
  std::array<std::array<std::uint8_t, kDirections + 1>, kDirections> alike{};  // [bin][mark]: 0, 1

  Continuation() {
    for (int b = 0; b < kDirections; ++b) {
      along[b] = {static_cast<int>(std::lround(-kAhead * std::sin(b * M_PI / kDirections))),
                  static_cast<int>(std::lround(kAhead * std::cos(b * M_PI / kDirections)))};
      for (const int turn : {kDirections - 1, 0, 1}) alike[b][1 + (b + turn) % kDirections] = 1;
    }
  }
};

/// An edgel counts when the contour goes on in both directions along its tangent.
bool continues(const cv::Mat& marks, int x, int y, int bin) {
  static const Continuation kContinuation;
  const auto& alike = kContinuation.alike[bin];
  const int dx = kContinuation.along[bin][0], dy = kContinuation.along[bin][1];
  const auto near = [&](int cx, int cy) {
    bool found = false;
    for (int j = -1; j <= 1; ++j) {
      const auto* p = marks.ptr<std::uint8_t>(cy + j) + cx;
      found |= (alike[p[-1]] | alike[p[0]] | alike[p[1]]) != 0;
    }
    return found;
  };
  return near(x + dx, y + dy) && near(x - dx, y - dy);
}

/// Ideal field positions of base pixels, on a coarse grid, bilinear between.
class UndistortGrid {
 public:
  UndistortGrid(const Camera& camera, const Base& base, Field* field) {
    step_ = kGridStep;
    nx_ = base.grey.cols / step_ + 2;
    ny_ = base.grey.rows / step_ + 2;
    Eigen::AlignedBox2d box;
    for (int j = 0; j < ny_; ++j) {
      for (int i = 0; i < nx_; ++i) {
        const double s = base.shrink, half = 0.5 * (s - 1.0);
        const Eigen::Vector2d p =
            camera.undistort({std::min(i * step_, base.grey.cols - 1) * s + half,
                              std::min(j * step_, base.grey.rows - 1) * s + half});
        grid_.push_back(p);
        box.extend(p);
      }
    }
    field->image_px = 2.0 * base.shrink;
    field->focal = 0.5 * (camera.model().fx + camera.model().fy) / field->image_px;
    field->cx = -box.min().x() * field->focal + 1.0;
    field->cy = -box.min().y() * field->focal + 1.0;
    field->width = static_cast<int>(std::ceil(box.sizes().x() * field->focal)) + 3;
    field->height = static_cast<int>(std::ceil(box.sizes().y() * field->focal)) + 3;
    for (auto& p : grid_) p = p * field->focal + Eigen::Vector2d(field->cx, field->cy);
    last_x_ = base.grey.cols - 1;
    last_y_ = base.grey.rows - 1;
  }

  Eigen::Vector2d operator()(int x, int y) const {
    const int i = x / step_, j = y / step_;
    const int w = std::min((i + 1) * step_, last_x_) - i * step_;
    const int h = std::min((j + 1) * step_, last_y_) - j * step_;
    const double a = w > 0 ? static_cast<double>(x - i * step_) / w : 0.0;
    const double b = h > 0 ? static_cast<double>(y - j * step_) / h : 0.0;
    const auto* g = grid_.data() + j * nx_ + i;
    return (1 - b) * ((1 - a) * g[0] + a * g[1]) + b * ((1 - a) * g[nx_] + a * g[nx_ + 1]);
  }

 private:
  int step_ = 0, nx_ = 0, ny_ = 0, last_x_ = 0, last_y_ = 0;
  std::vector<Eigen::Vector2d> grid_;
};

/// All directions of a pixel at once.
typedef std::uint8_t Directions __attribute__((vector_size(kDirections), aligned(1), may_alias));

inline Directions lower(const Directions& a, const Directions& b) { return a < b ? a : b; }

/// One row of a pass of the 3-4 chamfer distance transform: every pixel from its neighbour `before`
/// in the row and the three of the row `above`, in steps of +-1 pixel. No overflow: distances are
/// at most kFarDistance.
void relaxRow(int w, int step, const Directions* above, Directions* row) {
  Directions before = row[0], left = above[0], here = above[0];
  for (int k = 0; k < w; ++k, above += step, row += step) {
    const Directions right = k + 1 < w ? above[step] : here;
    const Directions side = lower(before, here) + 3, corner = lower(left, right) + 4;
    before = *row = lower(*row, lower(side, corner));
    left = here;
    here = right;
  }
}

/// Two-pass 3-4 chamfer distance transform of all directions at once, of rows of `w` pixels.
void distanceTransform(int w, const std::vector<std::uint8_t*>& rows) {
  std::vector<std::uint8_t> outside(static_cast<std::size_t>(w) * kDirections, kFarDistance);
  const auto row = [](std::uint8_t* of) { return reinterpret_cast<Directions*>(of); };
  std::uint8_t* last = outside.data();
  for (std::uint8_t* const here : rows) {
    relaxRow(w, 1, row(last), row(here));
    last = here;
  }
  last = outside.data();
  for (auto here = rows.rbegin(); here != rows.rend(); last = *here++)
    relaxRow(w, -1, row(last) + w - 1, row(*here) + w - 1);
}

/// An edgel in the field.
struct Edgel {
  int row, place;  ///< place in the row
  bool is_faint;
};

/// The distances from the edgels in bands, each with as many more rows as the farthest distance
/// spans: the same result on any number of threads.
/// @param faint  distance of an edgel that may be texture
void setDistances(const std::vector<std::vector<Edgel>>& edgels, std::uint8_t faint, int threads,
                  Field* field) {
  constexpr int kHalo = kFarDistance / kUnitsPerFieldPixel;
  const int h = field->height;
  const std::size_t row = static_cast<std::size_t>(field->width) * kDirections;
  field->distance.assign(h * row, kFarDistance);
  parallelFor(threads, threads, [&](int band) {
    const int y0 = h * band / threads, y1 = h * (band + 1) / threads;
    const int from = std::max(0, y0 - kHalo), to = std::min(h, y1 + kHalo);
    // The rows of other bands are their own: these are copies.
    std::vector<std::uint8_t> others(((y0 - from) + (to - y1)) * row, kFarDistance);
    std::uint8_t* other = others.data();
    std::vector<std::uint8_t*> rows;
    for (int y = from; y < to; ++y) {
      const bool own = y0 <= y && y < y1;
      rows.push_back(own ? field->distance.data() + y * row : other);
      if (!own) other += row;
    }
    for (const auto& found : edgels) {
      for (const Edgel& edgel : found) {
        if (edgel.row < from || edgel.row >= to) continue;
        std::uint8_t& distance = rows[edgel.row - from][edgel.place];
        distance = std::min(distance, edgel.is_faint ? faint : std::uint8_t{0});
      }
    }
    distanceTransform(field->width, rows);
  });
}

}  // namespace

/// An edge of a neighbouring direction serves too, at a cost ([2]).
PBP_SIMD
static void spreadDirections(Field* field, double cost_px, int y0, int y1) {
  static_assert(kDirections == 16, "the turns below are written out");
  const auto cost = static_cast<std::uint8_t>(std::lround(cost_px * kUnitsPerFieldPixel));
  auto* p = reinterpret_cast<Directions*>(field->distance.data());
  const std::ptrdiff_t from = static_cast<std::ptrdiff_t>(y0) * field->width;
  const std::ptrdiff_t to = static_cast<std::ptrdiff_t>(y1) * field->width;
  for (std::ptrdiff_t i = from; i < to; ++i) {
    const Directions here = p[i];
    const Directions next = PBP_SHUFFLE(here, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 0);
    const Directions last = PBP_SHUFFLE(here, 15, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14);
    const Directions side = lower(next, last) + cost;
    p[i] = lower(here, side);
  }
}

namespace {

/// The edgels that rows y0 to y1 hold.
std::vector<Edgel> placeEdgels(const Marks& marks, const UndistortGrid& undistort, int y0, int y1) {
  std::vector<Edgel> out;
  for (int y = std::max(y0, kBorder); y < std::min(y1, marks.direction.rows - kBorder); ++y) {
    const auto *row = marks.direction.ptr(y), *is_faint = marks.is_faint.ptr(y);
    for (int x = kBorder; x < marks.direction.cols - kBorder; ++x) {
      if (row[x] == 0 || !continues(marks.direction, x, y, row[x] - 1)) continue;
      const Eigen::Vector2d p = undistort(x, y);
      const int u = static_cast<int>(p.x() + 0.5), v = static_cast<int>(p.y() + 0.5);
      out.push_back({v, u * kDirections + row[x] - 1, is_faint[x] != 0});
    }
  }
  return out;
}

/// The field of the image at one scale; adds the number of its edgels.
Field makeField(const Base& base, const std::array<float, 256>& noise, const Camera& camera,
                const EdgesParams& params, int threads, std::size_t* count) {
  const Texture texture(base.grey, threads);
  Marks marks{cv::Mat_<std::uint8_t>(base.grey.size(), std::uint8_t{0}),
              cv::Mat_<std::uint8_t>(base.grey.size(), std::uint8_t{0})};
  const int bands = (base.grey.rows + kBand - 1) / kBand;
  parallelFor(bands, threads, [&](int i) {
    markEdgels(base.grey, noise, texture, params, i * kBand,
               std::min((i + 1) * kBand, base.grey.rows), &marks);
  });

  Field field;
  const UndistortGrid undistort(camera, base, &field);
  std::vector<std::vector<Edgel>> edgels(bands);
  parallelFor(bands, threads, [&](int i) {
    edgels[i] = placeEdgels(marks, undistort, i * kBand, (i + 1) * kBand);
  });
  const auto farther =
      static_cast<std::uint8_t>(std::lround(params.texture_cost_px * kUnitsPerFieldPixel));
  for (const auto& band : edgels) *count += band.size();
  setDistances(edgels, farther, threads, &field);
  parallelFor((field.height + kBand - 1) / kBand, threads, [&](int i) {
    spreadDirections(&field, params.direction_cost_px, i * kBand,
                     std::min((i + 1) * kBand, field.height));
  });
  return field;
}

}  // namespace

EdgeMap findEdges(const cv::Mat& image, const Camera& camera, const std::vector<double>& radii_px,
                  const EdgesParams& params, int threads) {
  EdgeMap map;
  map.image = toEightBits(image);
  const int usual = usualShrink(map.image, params);
  std::vector<int> shrinks;  // by field
  for (const double radius_px : radii_px) {
    const int shrink = std::max(usual, static_cast<int>(radius_px / params.radius_px));
    const auto known = std::find(shrinks.begin(), shrinks.end(), shrink);
    map.field_of.push_back(static_cast<std::size_t>(known - shrinks.begin()));
    if (known == shrinks.end()) shrinks.push_back(shrink);
  }
  const Base usual_base = shrinkImage(map.image, usual);
  map.noise = estimateNoise(usual_base.grey);
  for (const int shrink : shrinks) {
    const Base base = shrink == usual ? usual_base : shrinkImage(map.image, shrink);
    const auto noise = shrink == usual ? map.noise : estimateNoise(base.grey);
    map.fields.push_back(makeField(base, noise, camera, params, threads, &map.edgels));
  }
  return map;
}

EdgeMap findEdges(const cv::Mat& image, const Camera& camera, const EdgesParams& params,
                  int threads) {
  return findEdges(image, camera, {params.radius_px}, params, threads);
}

EdgeMap withoutFields(const cv::Mat& image, const EdgesParams& params) {
  EdgeMap map;
  map.image = toEightBits(image);
  map.noise = estimateNoise(shrinkImage(map.image, usualShrink(map.image, params)).grey);
  return map;
}

}  // namespace planar_bin_picking
