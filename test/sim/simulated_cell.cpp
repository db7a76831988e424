// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/simulated_cell.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <stdexcept>

namespace planar_bin_picking::cell {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kBevel = 0.00015;  // metres

Mesh box(const Eigen::Vector3d& center, const Eigen::Vector3d& half) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d corner((i & 1 ? 1.0 : -1.0) * half.x(), (i & 2 ? 1.0 : -1.0) * half.y(),
                                 (i & 4 ? 1.0 : -1.0) * half.z());
    mesh.points.push_back((center + corner).cast<float>());
  }
  constexpr unsigned kSides[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                     {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& s : kSides) {
    mesh.faces.push_back({s[0], s[1], s[2]});
    mesh.faces.push_back({s[0], s[2], s[3]});
  }
  return mesh;
}

/// Floor and walls.
std::vector<Mesh> binMeshes(const Bin& bin) {
  const double x = 0.5 * bin.length, y = 0.5 * bin.width, w = 0.5 * bin.wall, h = 0.5 * bin.height;
  return {box({0.0, 0.0, -w}, {x + 2 * w, y + 2 * w, w}), box({x + w, 0.0, h}, {w, y + 2 * w, h}),
          box({-x - w, 0.0, h}, {w, y + 2 * w, h}), box({0.0, y + w, h}, {x, w, h}),
          box({0.0, -y - w, h}, {x, w, h})};
}

std::vector<Mesh> allMeshes(const std::vector<PartKind>& kinds, const Bin& bin) {
  std::vector<Mesh> meshes;
  for (const PartKind& kind : kinds) meshes.push_back(makeMesh(kind.fine, kBevel));
  for (Mesh& mesh : binMeshes(bin)) meshes.push_back(std::move(mesh));
  return meshes;
}

/// A print tells all poses apart, unless it lies below.
void setSymmetricPoses(const std::vector<Eigen::Isometry3d>& same_shape, bool is_printed,
                       PartKind* kind) {
  kind->symmetric_poses = kind->back_symmetric_poses = same_shape;
  if (!is_printed) return;
  kind->symmetric_poses = {Eigen::Isometry3d::Identity()};
  auto& turns = kind->back_symmetric_poses;
  turns.erase(std::remove_if(turns.begin(), turns.end(),
                             [](const Eigen::Isometry3d& T) { return T.linear()(2, 2) < 0.0; }),
              turns.end());
}

Eigen::Vector3f toFloat(const Eigen::Vector3d& p) { return p.cast<float>(); }

}  // namespace

PartKind loadPartKind(const std::string& yaml_path) {
  const std::filesystem::path path(yaml_path);
  const YAML::Node root = YAML::LoadFile(yaml_path);
  if (!root["drawing"] || !root["thickness_mm"] || !root["pick_poses"])
    throw std::runtime_error(yaml_path + ": needs drawing, thickness_mm and pick_poses");
  PartKind kind;
  kind.name = path.stem().string();
  const std::string drawing = (path.parent_path() / root["drawing"].as<std::string>()).string();
  const double thickness = 1e-3 * root["thickness_mm"].as<double>();
  kind.fine = loadShape(drawing, thickness, 1e-5);
  kind.coarse = loadShape(drawing, thickness, 3e-4);
  const Shape shape = loadShape(drawing, thickness, 5e-5);
  const auto same_shape = symmetries(shape, 2e-4);
  setSymmetricPoses(same_shape, !shape.prints.empty(), &kind);
  for (const auto& pick : root["pick_poses"]) {
    const Eigen::Vector3d p(1e-3 * pick["position_mm"][0].as<double>(),
                            1e-3 * pick["position_mm"][1].as<double>(), 0.0);
    for (const auto& T : same_shape) kind.grasps.emplace_back((T * p).head<2>());
  }
  return kind;
}

const char* nameOf(PickResult result) {
  switch (result) {
    case PickResult::kPicked:
      return "picked";
    case PickResult::kWall:
      return "the tool touches the bin";
    case PickResult::kNothing:
      return "no part below the cup";
    case PickResult::kLateral:
      return "off the grasp point";
    case PickResult::kAbove:
      return "the cup hangs above the part";
    case PickResult::kDepth:
      return "the tool runs into the part";
    case PickResult::kTilt:
      return "the cup does not lie flat";
    case PickResult::kCovered:
      return "the cup is not on one part alone";
    case PickResult::kLoaded:
      return "too much lies on the part";
  }
  return "";
}

Lens lensOver(const Bin& bin, double height, double megapixels) {
  Lens lens;
  if (megapixels > 3.0) lens.width = 2448, lens.height = 2048;
  constexpr double kMargin = 1.12;
  const double at_top = height - bin.height;
  lens.fx = std::min(lens.width * at_top / (kMargin * bin.length),
                     lens.height * at_top / (kMargin * bin.width));
  lens.fy = 0.9995 * lens.fx;
  lens.cx = 0.5 * lens.width - 11.3;
  lens.cy = 0.5 * lens.height + 7.6;
  lens.d = {-0.092, 0.061, -2.8e-4, -3.1e-4, 0.0};
  return lens;
}

SimulatedCell::SimulatedCell(const CellConfig& config, std::vector<PartKind> kinds)
    : config_(config),
      kinds_(std::move(kinds)),
      eye_(config.lens),
      world_(allMeshes(kinds_, config.bin)) {
  if (config_.counts.size() != kinds_.size())
    throw std::invalid_argument("there must be one count for each kind of part");
  check(config_.sensor.encoding);
  for (const PartKind& kind : kinds_) prints_.emplace_back(kind.fine);
  refill(config.seed);
}

SimulatedCell::~SimulatedCell() = default;

void SimulatedCell::refill(std::uint64_t seed) {
  std::vector<Shape> shapes;
  for (const PartKind& kind : kinds_) shapes.push_back(kind.coarse);
  heap_ = std::make_unique<Heap>(config_.bin, shapes, seed);
  for (std::size_t i = 0; i < kinds_.size(); ++i)
    heap_->pour(static_cast<int>(i), config_.counts[i]);
  pictures_ = failures_ = 1000 * seed;
  update();
}

void SimulatedCell::update() {
  bodies_ = heap_->bodies();
  std::vector<Instance> instances;
  looks_ = {};
  const auto add = [&](int mesh, const Eigen::Isometry3d& T, const std::string& name, int seed) {
    instances.push_back({mesh, T});
    looks_.materials.push_back(material(name));
    looks_.T_body_base.push_back(T.inverse());
    looks_.seeds.push_back(static_cast<std::uint32_t>(seed));
    const bool is_printed =
        mesh < static_cast<int>(prints_.size()) && !prints_[static_cast<std::size_t>(mesh)].empty();
    looks_.prints.push_back(is_printed ? &prints_[static_cast<std::size_t>(mesh)] : nullptr);
  };
  for (const Body& body : bodies_) add(body.kind, body.T_base_part, config_.material, body.id);
  for (int i = 0; i < 5; ++i)  // floor and walls
    add(static_cast<int>(kinds_.size()) + i, Eigen::Isometry3d::Identity(), "plastic", 0);
  world_.place(instances);
}

cv::Mat SimulatedCell::takePicture(const Eigen::Isometry3d& T_base_camera,
                                   double exposure_seconds) {
  const auto light =
      eye_.look(world_, looks_, makeLamps(config_.light, T_base_camera), T_base_camera);
  return expose(light, config_.sensor, exposure_seconds, ++pictures_);
}

double SimulatedCell::exposureFor(const Eigen::Isometry3d& T_base_camera) const {
  constexpr double kPercentile = 97.0;
  const auto light =
      eye_.look(world_, looks_, makeLamps(config_.light, T_base_camera), T_base_camera);
  return cell::exposureFor(light, config_.sensor, kPercentile);
}

bool SimulatedCell::toolIsFree(const Eigen::Isometry3d& T_base_tool) const {
  const Bin& bin = config_.bin;
  const double r = config_.suction.tool_radius;
  const Eigen::Vector3d tip = T_base_tool.translation(), axis = T_base_tool.linear().col(2);
  // The tool is a cylinder; the highest of it that is still between the walls counts as much.
  for (double s = 0.0; s <= config_.suction.tool_length; s += 0.005) {
    const Eigen::Vector3d p = tip - s * axis;
    if (p.z() > bin.height) break;
    if (std::abs(p.x()) + r > 0.5 * bin.length || std::abs(p.y()) + r > 0.5 * bin.width)
      return false;
  }
  return tip.z() > -config_.suction.depth_max;
}

PickResult SimulatedCell::judge(const Eigen::Isometry3d& T_base_tool, int* id) const {
  constexpr float kAbove = 0.25f;
  const Suction& suction = config_.suction;
  if (!toolIsFree(T_base_tool)) return PickResult::kWall;
  const Eigen::Vector3f axis = toFloat(T_base_tool.linear().col(2));
  const auto castFrom = [&](double x, double y) {
    const Eigen::Vector3d rim = T_base_tool * Eigen::Vector3d(x, y, 0.0);
    return world_.cast(toFloat(rim) - kAbove * axis, axis, 0.0f, kAbove + 0.3f);
  };
  const auto hit = castFrom(0.0, 0.0);
  const auto isPart = [&](const std::optional<Hit>& h) {
    return h && h->body < static_cast<int>(bodies_.size());
  };
  if (!isPart(hit)) return PickResult::kNothing;
  const Body& body = bodies_[static_cast<std::size_t>(hit->body)];
  *id = body.id;
  if (hit->distance - kAbove > suction.depth_max) return PickResult::kAbove;
  const Eigen::Vector3d contact =
      T_base_tool.translation() + (hit->distance - kAbove) * T_base_tool.linear().col(2);
  const Eigen::Vector3d x_part = body.T_base_part.inverse() * contact;
  double lateral = std::numeric_limits<double>::infinity();
  for (const auto& grasp : kind(body.kind).grasps)
    lateral = std::min(lateral, (grasp - x_part.head<2>()).norm());
  if (lateral > suction.lateral_max) return PickResult::kLateral;
  if (kAbove - hit->distance > suction.depth_max) return PickResult::kDepth;
  const double cosine = std::abs(body.T_base_part.linear().col(2).dot(T_base_tool.linear().col(2)));
  if (cosine < std::cos(suction.tilt_max_deg * kPi / 180.0)) return PickResult::kTilt;
  // The rim on the part and nothing else; and nothing that the tool would meet on its way down.
  for (const double radius : {0.5 * suction.radius, suction.radius, suction.tool_radius}) {
    for (int i = 0; i < 12; ++i) {
      const double a = 2.0 * kPi * i / 12.0;
      const auto rim = castFrom(radius * std::cos(a), radius * std::sin(a));
      const bool under_cup = radius <= suction.radius;
      if (under_cup && (!isPart(rim) || rim->body != hit->body)) return PickResult::kCovered;
      const double slope = radius * std::tan(suction.tilt_max_deg * kPi / 180.0);
      const double higher = hit->distance - (rim ? rim->distance : 1.0f);
      if (higher > slope + suction.unevenness_max) return PickResult::kCovered;
      if (under_cup && -higher > slope + suction.unevenness_max) return PickResult::kCovered;
    }
  }
  if (heap_->load(body.id) > suction.load_max) return PickResult::kLoaded;
  return PickResult::kPicked;
}

PickResult SimulatedCell::pick(const Eigen::Isometry3d& T_base_tool) {
  int id = 0;
  const PickResult result = judge(T_base_tool, &id);
  if (result == PickResult::kPicked) {
    heap_->remove(id);
  } else if (result != PickResult::kWall && result != PickResult::kNothing &&
             result != PickResult::kAbove) {
    // Every second failure drags the part a little, each time to another side.
    ++failures_;
    const double a = 2.399963 * static_cast<double>(failures_ % 1000);
    if (failures_ % 2 == 0)
      heap_->push(id, T_base_tool.translation(),
                  0.15 * Eigen::Vector3d(std::cos(a), std::sin(a), 0.3));
  }
  update();
  return result;
}

double SimulatedCell::visibleFraction(std::size_t body, bool front_up,
                                      const Eigen::Vector3d& eye) const {
  constexpr int kAcross = 24;
  const PartKind& kind = kinds_[static_cast<std::size_t>(bodies_[body].kind)];
  Eigen::AlignedBox2d box;
  for (const auto& p : kind.fine.outer) box.extend(p);
  const double z = front_up ? 0.0 : -kind.fine.thickness;
  int all = 0, seen = 0;
  for (int j = 0; j < kAcross; ++j) {
    for (int i = 0; i < kAcross; ++i) {
      const Eigen::Vector2d p =
          box.min() + box.sizes().cwiseProduct(Eigen::Vector2d(i + 0.5, j + 0.5)) / kAcross;
      if (!contains(kind.fine, p)) continue;
      ++all;
      const Eigen::Vector3d way =
          bodies_[body].T_base_part * Eigen::Vector3d(p.x(), p.y(), z) - eye;
      if (!world_.blocked(toFloat(eye), toFloat(way), 0.0f, 0.9995f)) ++seen;
    }
  }
  return all > 0 ? static_cast<double>(seen) / all : 0.0;
}

std::vector<TruePart> SimulatedCell::truth(const Eigen::Isometry3d& T_base_camera) const {
  const Eigen::Vector3d eye = T_base_camera.translation();
  std::vector<TruePart> parts;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    TruePart part{bodies_[i].id, bodies_[i].kind, true, 0.0, bodies_[i].T_base_part};
    part.front_up =
        part.T_base_part.linear().col(2).dot(eye - part.T_base_part.translation()) > 0.0;
    part.visible_fraction = visibleFraction(i, part.front_up, eye);
    parts.push_back(part);
  }
  return parts;
}

}  // namespace planar_bin_picking::cell
