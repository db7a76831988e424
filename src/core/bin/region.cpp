// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/bin/region.h"

#include "base/atomic_file.h"
#include "base/polygon.h"
#include "base/yaml_file.h"
#include "base/yaml_text.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <limits>
#include <locale>
#include <sstream>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

std::string at(const Eigen::Vector2d& point, const int digits) {
  const double unit = std::pow(10.0, -digits);
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << std::fixed << std::setprecision(digits);
  // Nobody needs to read of -0.000.
  text << std::round(point.x() / unit) * unit + 0.0 << ", "
       << std::round(point.y() / unit) * unit + 0.0;
  return text.str();
}

/// Grows to hold points.
struct Bounds {
  Eigen::Vector2d min = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d max = -min;
  void add(const Eigen::Vector2d& p) { min = min.cwiseMin(p), max = max.cwiseMax(p); }
  void meet(const Bounds& other) { min = min.cwiseMax(other.min), max = max.cwiseMin(other.max); }
  bool isEmpty() const { return !(min.x() < max.x() && min.y() < max.y()); }
};

Bounds boundsOf(const RegionOutline& outline) {
  Bounds bounds;
  for (const Eigen::Vector2d& p : outline) bounds.add(p);
  return bounds;
}

/// In the picture: where lines of sight meet the region between the distances. Lines of sight,
/// since an upright prism has no end.
/// @return  nothing where that cannot be told
std::optional<Bounds> boundsInPicture(const RegionOutline& metres, const Camera& camera,
                                      const Eigen::Isometry3d& T_camera_region,
                                      const Distances& distances) {
  Bounds bounds;
  for (const Eigen::Vector2d& p : metres) {
    const Eigen::Vector3d foot = T_camera_region * Eigen::Vector3d(p.x(), p.y(), 0.0);
    const Eigen::Vector3d up = T_camera_region.linear().col(2);
    // An edge of the prism that runs across the view meets no plane of one distance.
    constexpr double kSteepLeast = 0.5;
    if (std::abs(up.z()) < kSteepLeast) return std::nullopt;
    for (const double depth : {distances.min, distances.max})
      bounds.add(camera.project(foot + up * ((depth - foot.z()) / up.z())));
  }
  return bounds;
}

}  // namespace

RegionOutline regionOutline(const std::vector<double>& numbers) {
  if (numbers.empty()) return {};
  if (numbers.size() % 2 != 0 || numbers.size() < 4) {
    throw std::invalid_argument("has " + std::to_string(numbers.size()) +
                                " numbers; give x, y, x, y: two corners of a box, or the three or "
                                "more of a polygon");
  }
  RegionOutline points;
  for (std::size_t i = 0; i < numbers.size(); i += 2)
    points.emplace_back(numbers[i], numbers[i + 1]);
  if (points.size() == 2) {
    const Eigen::Vector2d a = points[0], c = points[1];
    points = {a, {c.x(), a.y()}, c, {a.x(), c.y()}};
  }
  return regionOutline(std::move(points));
}

RegionOutline regionOutline(RegionOutline points) {
  if (points.size() < 3) {
    throw std::invalid_argument("has " + std::to_string(points.size()) +
                                " corners; a polygon has three or more");
  }
  for (const Eigen::Vector2d& p : points)
    if (!p.allFinite()) throw std::invalid_argument("has a corner that is no number");
  const double side = (boundsOf(points).max - boundsOf(points).min).maxCoeff();
  constexpr double kThinnest = 1e-6;  // of its length: else all points stand on one line
  if (!(std::abs(signedArea(points)) > kThinnest * side * side))
    throw std::invalid_argument("has no area");
  if (const auto crossing = findCrossing({points}, 0.0))
    throw std::invalid_argument("crosses itself at " + at(crossing->point, 3));
  return points;
}

bool isWithin(const RegionOutline& outline, const Eigen::Vector2d& point) {
  return outline.empty() || contains(outline, point);
}

std::optional<std::string> outsideOf(const Region& region, const Camera& camera,
                                     const Eigen::Isometry3d& T_region_camera,
                                     const Eigen::Vector3d& p_camera) {
  const Eigen::Vector2d pixel = camera.project(p_camera);
  if (!isWithin(region.pixels, pixel))
    return "its face's centre lies outside of the region in the picture, at pixel " + at(pixel, 0);
  const Eigen::Vector2d place = (T_region_camera * p_camera).head<2>();
  if (!isWithin(region.metres, place))
    return "its face's centre lies outside of the region, at " + at(place, 3) + " m";
  return std::nullopt;
}

std::optional<PixelBox> windowOf(const Region& region, const Camera& camera,
                                 const Eigen::Isometry3d& T_region_camera,
                                 const Distances& distances, double reach) {
  const Camera::Model& model = camera.model();
  Bounds bounds;
  bounds.add({0.0, 0.0});
  bounds.add({model.width, model.height});
  const Bounds all = bounds;
  if (!region.pixels.empty()) bounds.meet(boundsOf(region.pixels));
  if (!region.metres.empty()) {
    const auto seen = boundsInPicture(region.metres, camera, T_region_camera.inverse(), distances);
    if (seen) bounds.meet(*seen);
  }
  if (bounds.isEmpty()) return std::nullopt;
  const double margin = std::ceil(std::max(model.fx, model.fy) * reach / distances.min);
  bounds.min.array() -= margin;
  bounds.max.array() += margin;
  bounds.meet(all);
  PixelBox box;
  box.left = static_cast<int>(std::floor(bounds.min.x()));
  box.top = static_cast<int>(std::floor(bounds.min.y()));
  box.width = static_cast<int>(std::ceil(bounds.max.x())) - box.left;
  box.height = static_cast<int>(std::ceil(bounds.max.y())) - box.top;
  if (box.width == model.width && box.height == model.height) return std::nullopt;
  return box;
}

void saveRegion(const std::string& path, const RegionFile& region) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << std::setprecision(6)
       << "# Taught by points in rviz: x, y, x, y, ... in metres of the frame.\n"
       << "frame: " << yamlText(region.frame) << "\nregion: [";
  for (std::size_t i = 0; i < region.metres.size(); ++i)
    text << (i > 0 ? ", " : "") << region.metres[i].x() << ", " << region.metres[i].y();
  text << "]\n";
  writeTogether({{path, text.str()}});
}

std::optional<RegionFile> loadRegion(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return std::nullopt;
  const YAML::Node root = loadYamlMap(path);
  refuseUnknownKeys(root, path, {"frame", "region"});
  RegionFile file;
  file.frame = valueAs<std::string>(root["frame"], path, "frame", "the frame of the region");
  const auto numbers =
      valueAs<std::vector<double>>(root["region"], path, "region", "a list of numbers");
  try {
    file.metres = regionOutline(numbers);
  } catch (const std::invalid_argument& wrong) {
    throw std::runtime_error(path + ": region " + wrong.what());
  }
  if (file.metres.empty()) throw std::runtime_error(path + ": region is empty; delete the file");
  return file;
}

}  // namespace planar_bin_picking
