// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/picture.h"

#include "sim/workers.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

namespace planar_bin_picking::cell {
namespace {

constexpr float kFar = 10.0f;          // metres
constexpr float kSamePlane = 0.0004f;  // metres off a spot's plane that still are its surface
constexpr int kNothing = -1;
constexpr float kInk = 0.7f;  // share of the light that ink takes away
constexpr int kFine = 1800;   // pixels across, from which shadows need not be looked at that finely

struct Seen {
  int body = kNothing;
  Eigen::Vector3f position, normal;
};

bool sameSurface(const Seen& a, const Seen& b) {
  return a.body == b.body &&
         (a.body == kNothing || (a.normal.dot(b.normal) > 0.95f &&
                                 std::abs((b.position - a.position).dot(a.normal)) < kSamePlane));
}

/// Everything about one picture while it is made.
class Painter {
 public:
  Painter(const Lens& lens, const std::vector<Eigen::Vector2f>& rays, const Raycaster& world,
          const Looks& looks, const Lamps& lamps, const Eigen::Isometry3d& T_base_camera)
      : w_(lens.width),
        h_(lens.height),
        cell_(lens.width > kFine ? 4 : 2),
        rays_(rays),
        world_(world),
        looks_(looks),
        lamps_(lamps),
        R_(T_base_camera.linear().cast<float>()),
        eye_(T_base_camera.translation().cast<float>()),
        seen_(static_cast<std::size_t>(w_) * h_) {
    for (const auto& T : looks.T_body_base) T_body_base_.push_back(T.cast<float>());
  }

  cv::Mat_<float> paint() {
    forEachRow(h_, [&](int y) {
      for (int x = 0; x < w_; ++x) seen_[index(x, y)] = look(rays_[index(x, y)]);
    });
    cells_x_ = (w_ + cell_ - 1) / cell_;
    cells_y_ = (h_ + cell_ - 1) / cell_;
    cells_.resize(static_cast<std::size_t>(cells_x_) * cells_y_);
    forEachRow(cells_y_, [&](int j) {
      for (int i = 0; i < cells_x_; ++i) {
        const Seen& seen = seen_[index(cell_ * i, cell_ * j)];
        if (seen.body != kNothing)
          cells_[static_cast<std::size_t>(j) * cells_x_ + i] = arriving(seen, i % 2 + 2 * (j % 2));
      }
    });
    cv::Mat_<float> light(h_, w_);
    forEachRow(h_, [&](int y) {
      for (int x = 0; x < w_; ++x) {
        light(y, x) = isEdge(x, y) ? paintEdge(x, y)
                                   : shade(seen_[index(x, y)], static_cast<float>(x),
                                           static_cast<float>(y), 0);
      }
    });
    return light;
  }

 private:
  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y) * w_ + x; }

  Seen look(const Eigen::Vector2f& ray) const {
    const Eigen::Vector3f direction = R_ * Eigen::Vector3f(ray.x(), ray.y(), 1.0f);
    const auto hit = world_.cast(eye_, direction, 0.01f, kFar);
    if (!hit) return {};
    return {hit->body, eye_ + hit->distance * direction, hit->normal};
  }

  Arriving arriving(const Seen& seen, int share) const {
    const Spot spot{seen.position, seen.normal, (eye_ - seen.position).normalized()};
    return gather(world_, lamps_, spot,
                  looks_.materials[static_cast<std::size_t>(seen.body)].exponent, share);
  }

  bool isEdge(int x, int y) const {
    const Seen& here = seen_[index(x, y)];
    return (x > 0 && !sameSurface(here, seen_[index(x - 1, y)])) ||
           (x + 1 < w_ && !sameSurface(here, seen_[index(x + 1, y)])) ||
           (y > 0 && !sameSurface(here, seen_[index(x, y - 1)])) ||
           (y + 1 < h_ && !sameSurface(here, seen_[index(x, y + 1)]));
  }

  float paintEdge(int x, int y) const {
    constexpr int kSide = 3;
    // The rays between pixels: from this one's and its neighbours'.
    const int x1 = x + 1 < w_ ? x + 1 : x - 1, y1 = y + 1 < h_ ? y + 1 : y - 1;
    const Eigen::Vector2f center = rays_[index(x, y)];
    const Eigen::Vector2f right = (rays_[index(x1, y)] - center) * static_cast<float>(x1 - x);
    const Eigen::Vector2f down = (rays_[index(x, y1)] - center) * static_cast<float>(y1 - y);
    float sum = 0.0f;
    for (int j = 0; j < kSide; ++j) {
      for (int i = 0; i < kSide; ++i) {
        // Turned a little, so that upright edges meet nine columns, not three.
        const auto fi = static_cast<float>(i - 1), fj = static_cast<float>(j - 1);
        const float a = (fi + fj / kSide) / kSide, b = (fj - fi / kSide) / kSide;
        sum += shade(look(center + a * right + b * down), static_cast<float>(x) + a,
                     static_cast<float>(y) + b, i % 2 + 2 * (j % 2));
      }
    }
    return sum / (kSide * kSide);
  }

  /// Light that arrives, from the cells about a pixel that lie on its surface.
  Arriving shared(const Seen& seen, float x, float y, int share) const {
    constexpr float kReach = 1.5f;  // cells: with a tent this wide, the four shares weigh the same
    const float u = x / static_cast<float>(cell_), v = y / static_cast<float>(cell_);
    Arriving sum;
    float weights = 0.0f;
    for (int j = std::max(0, static_cast<int>(std::ceil(v - kReach)));
         j <= std::min(cells_y_ - 1, static_cast<int>(v + kReach)); ++j) {
      for (int i = std::max(0, static_cast<int>(std::ceil(u - kReach)));
           i <= std::min(cells_x_ - 1, static_cast<int>(u + kReach)); ++i) {
        if (!sameSurface(seen, seen_[index(cell_ * i, cell_ * j)])) continue;
        const float weight = (kReach + 0.01f - std::abs(u - static_cast<float>(i))) *
                             (kReach + 0.01f - std::abs(v - static_cast<float>(j)));
        const Arriving& cell = cells_[static_cast<std::size_t>(j) * cells_x_ + i];
        sum.diffuse += weight * cell.diffuse;
        sum.gloss += weight * cell.gloss;
        sum.mirror += weight * cell.mirror;
        weights += weight;
      }
    }
    if (weights <= 0.0f) return arriving(seen, share);
    return {sum.diffuse / weights, sum.gloss / weights, sum.mirror / weights};
  }

  float shade(const Seen& seen, float x, float y, int share) const {
    if (seen.body == kNothing) return 0.02f;
    const auto body = static_cast<std::size_t>(seen.body);
    const Material& m = looks_.materials[body];
    const Arriving light = shared(seen, x, y, share);
    const Eigen::Vector3f x_body = T_body_base_[body] * seen.position;
    const bool is_printed = body < looks_.prints.size() && looks_.prints[body] != nullptr;
    const float ink = is_printed ? looks_.prints[body]->at(x_body) : 0.0f;
    return (1.0f - kInk * ink) * pattern(m, x_body, looks_.seeds[body]) *
           (m.diffuse * light.diffuse + m.gloss * light.gloss + m.mirror * light.mirror);
  }

  const int w_, h_;
  const int cell_;  ///< pixels
  const std::vector<Eigen::Vector2f>& rays_;
  const Raycaster& world_;
  const Looks& looks_;
  const Lamps& lamps_;
  const Eigen::Matrix3f R_;
  const Eigen::Vector3f eye_;
  std::vector<Eigen::Isometry3f> T_body_base_;
  std::vector<Seen> seen_;
  std::vector<Arriving> cells_;
  int cells_x_ = 0, cells_y_ = 0;
};

/// Normal numbers; OpenCV's fill their tables at first use, which threads must not do at once.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : state_(seed) {}
  double normal() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    const double r = std::sqrt(-2.0 * std::log(uniform())), a = 6.283185307179586 * uniform();
    spare_ = r * std::sin(a);
    has_spare_ = true;
    return r * std::cos(a);
  }

 private:
  /// 0 < u <= 1
  double uniform() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (static_cast<double>((z ^ (z >> 31)) >> 11) + 1.0) * 0x1.0p-53;
  }

  std::uint64_t state_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace

Eye::Eye(const Lens& lens)
    : lens_(lens), rays_(static_cast<std::size_t>(lens.width) * lens.height) {
  forEachRow(lens.height, [&](int y) {
    for (int x = 0; x < lens.width; ++x)
      rays_[static_cast<std::size_t>(y) * lens.width + x] =
          rayOf(lens, x, y).head<2>().cast<float>();
  });
}

cv::Mat_<float> Eye::look(const Raycaster& world, const Looks& looks, const Lamps& lamps,
                          const Eigen::Isometry3d& T_base_camera) const {
  return Painter(lens_, rays_, world, looks, lamps, T_base_camera).paint();
}

cv::Mat expose(const cv::Mat_<float>& light, const Sensor& sensor, double seconds,
               std::uint64_t seed) {
  check(sensor.encoding);
  cv::Mat_<float> blurred;
  if (sensor.blur_px > 0.0) {
    cv::GaussianBlur(light, blurred, {}, sensor.blur_px);
  } else {
    blurred = light;
  }
  const double electrons = seconds * sensor.light_per_second * sensor.full_well;
  cv::Mat out(light.size(), CV_8U);
  forEachRow(light.rows, [&](int y) {
    Dice random(seed * 1000003u + static_cast<std::uint64_t>(y) * 7919u);
    auto* row = out.ptr<std::uint8_t>(y);
    for (int x = 0; x < light.cols; ++x) {
      // The camera multiplies what a filter lets through until white looks white, noise and all.
      const double share = filterShare(sensor.encoding, x, y);
      const double expected = share * electrons * blurred(y, x);
      const double sigma = std::sqrt(expected + sensor.read_noise * sensor.read_noise);
      const double value = (expected + sigma * random.normal()) / share * 255.0 / sensor.full_well;
      row[x] = static_cast<std::uint8_t>(std::clamp(value + 0.5, 0.0, 255.0));
    }
  });
  return encode(out, sensor.encoding);
}

double exposureFor(const cv::Mat_<float>& light, const Sensor& sensor, double percentile) {
  std::vector<float> values(light.begin(), light.end());
  const auto rank =
      static_cast<std::ptrdiff_t>(percentile / 100.0 * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return 0.85 / (static_cast<double>(std::max(values[static_cast<std::size_t>(rank)], 1e-6f)) *
                 sensor.light_per_second);
}

}  // namespace planar_bin_picking::cell
