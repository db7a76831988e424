// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

/// `./run bench honesty [SCENES ...]`: whether covariance, visible fraction and score say what is
/// true. SCENES: folders as ../shared/scenes (the default), with open/ and parts/. Prints, over all
/// correct detections, the mean squared error normalised by its covariance (1 per dimension is
/// honest), the mean absolute error of the visible fraction, and precision and recall by threshold.

#include "reliability.h"

#include "planar_bin_picking/image/camera_file.h"
#include "planar_bin_picking/locate/locator.h"

#include <yaml-cpp/yaml.h>

#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace planar_bin_picking {
namespace {

struct Instance {
  std::string part;
  Eigen::Isometry3d T_camera_part;
  Face face;
  double visible;
  bool pickable;
};

/// Error of a detection: depth along the line of sight, lateral across it; angle about the part's
/// normal, tilt of it. Metres and radians; squared and normalised by the covariance in `nees`.
struct Error {
  double lateral, depth, angle, tilt;
  std::array<double, 4> nees;
  bool correct() const {
    constexpr double kDeg = M_PI / 180.0;
    return lateral <= 2e-3 && depth <= 8e-3 && angle <= 2.0 * kDeg && tilt <= 6.0 * kDeg;
  }
  double size() const {
    return lateral / 2e-3 + depth / 8e-3 + (angle / 2.0 + tilt / 6.0) * 180.0 / M_PI;
  }
};

constexpr std::array<const char*, 4> kKinds = {"lateral", "depth", "angle", "tilt"};
constexpr std::array<double, 4> kDimensions = {2.0, 1.0, 1.0, 2.0};

Eigen::Isometry3d poseOf(const YAML::Node& node) {
  const auto p = node["position"].as<std::vector<double>>();
  const auto q = node["orientation"].as<std::vector<double>>();
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized().toRotationMatrix();
  T.translation() << p[0], p[1], p[2];
  return T;
}

std::vector<Instance> truthOf(const std::string& file) {
  std::vector<Instance> out;
  for (const auto& node : YAML::LoadFile(file)["instances"]) {
    const double visible = node["visible_fraction"].as<double>();
    out.push_back(
        {node["part"].as<std::string>(), poseOf(node),
         node["face_up"].as<std::string>() == "front" ? Face::kFront : Face::kBack, visible,
         visible >= 0.95 && node["tilt_deg"].as<double>() <= 40.0 && node["in_image"].as<bool>()});
  }
  return out;
}

/// Turns of the part after which it looks the same.
std::vector<Eigen::Isometry3d> turnsOf(const PartModel& part, Face face) {
  const auto& symmetry = part.symmetry();
  if (part.hasPrint() && face == Face::kFront) return {Eigen::Isometry3d::Identity()};
  const Eigen::Translation3d centre(symmetry.center.x(), symmetry.center.y(),
                                    -0.5 * part.thickness());
  std::vector<Eigen::Isometry3d> out;
  const int order = symmetry.order == 0 ? 720 : symmetry.order;
  for (int k = 0; k < order; ++k) {
    const Eigen::AngleAxisd turn(2.0 * M_PI * k / order, Eigen::Vector3d::UnitZ());
    out.emplace_back(centre * turn * centre.inverse());
    if (!symmetry.mirror || part.hasPrint()) continue;
    const double a = symmetry.mirror_axis;
    const Eigen::AngleAxisd flip(M_PI, Eigen::Vector3d(std::cos(a), std::sin(a), 0.0));
    out.emplace_back(centre * turn * flip * centre.inverse());
  }
  return out;
}

Error errorOf(const PartModel& part, const Detection& d, const Eigen::Isometry3d& T_camera_true) {
  Eigen::Isometry3d T_part_centre = Eigen::Isometry3d::Identity();
  T_part_centre.translation() << part.center(), part.faceZ(d.face);
  const Eigen::Isometry3d T_camera_centre = d.T_camera_part * T_part_centre;
  const Eigen::Isometry3d off = T_camera_centre.inverse() * T_camera_true * T_part_centre;
  const Eigen::AngleAxisd turn(off.linear());
  const Eigen::Vector3d v = off.translation(), w = turn.angle() * turn.axis();
  const Eigen::Vector3d ray =
      T_camera_centre.linear().transpose() * T_camera_centre.translation().normalized();
  const Eigen::Vector3d side = ray.unitOrthogonal();
  Eigen::Matrix<double, 6, 6> axes = Eigen::Matrix<double, 6, 6>::Zero();  // rows: kinds' axes
  axes.block<1, 3>(0, 0) = side.transpose();
  axes.block<1, 3>(1, 0) = ray.cross(side).transpose();
  axes.block<1, 3>(2, 0) = ray.transpose();
  axes(3, 5) = axes(4, 3) = axes(5, 4) = 1.0;
  Vector6d xi;
  xi << v, w;
  const Vector6d e = axes * xi;
  const Matrix6d C = axes * d.covariance * axes.transpose();
  const auto nees = [&](int from, int n) {
    return e.segment(from, n).dot(C.block(from, from, n, n).ldlt().solve(e.segment(from, n)));
  };
  return {e.head<2>().norm(),
          std::abs(e(2)),
          std::abs(e(3)),
          e.tail<2>().norm(),
          {nees(0, 2), nees(2, 1), nees(3, 1), nees(4, 2)}};
}

struct Sums {
  std::array<double, 4> nees{};
  int correct = 0;
  double visible = 0.0;
  std::vector<std::pair<double, bool>> scores;  // score, right and not a duplicate
  std::vector<double> found;                    // scores of those on pickable instances
  int pickable = 0;
};

void judge(const std::vector<Detection>& detections, const std::vector<Instance>& truth,
           const LocateRequest& request, Sums* sums) {
  std::vector<bool> taken(truth.size(), false);
  for (const Detection& d : detections) {
    const PartModel& part = *request.parts[d.part];
    std::optional<Error> best;
    std::size_t of = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      if (truth[i].part != d.part_name || taken[i]) continue;
      for (const auto& S : turnsOf(part, truth[i].face)) {
        const Error error = errorOf(part, d, truth[i].T_camera_part * S);
        if (best && error.size() >= best->size()) continue;
        best = error;
        of = i;
      }
    }
    const bool correct = best && best->correct();
    sums->scores.emplace_back(d.score, correct);
    if (!correct) continue;
    taken[of] = true;
    ++sums->correct;
    sums->visible += std::abs(d.visible_fraction - truth[of].visible);
    // A full circle's angle says nothing.
    for (int k = 0; k < 4; ++k) {
      sums->nees[k] += k == 2 && part.symmetry().order == 0 ? 1.0 : best->nees[k];
    }
    if (truth[of].pickable) sums->found.push_back(d.score);
  }
  for (const Instance& i : truth) sums->pickable += i.pickable ? 1 : 0;
}

void runScene(const std::filesystem::path& scene, const std::filesystem::path& parts, Sums* sums) {
  const YAML::Node wanted = YAML::LoadFile((scene / "scene.yaml").string());
  LocateRequest request;
  for (const auto& name : wanted["parts"].as<std::vector<std::string>>()) {
    request.parts.push_back(
        std::make_shared<const PartModel>(loadPartFile((parts / (name + ".yaml")).string())));
  }
  request.distance_min = wanted["distance_min_m"].as<double>();
  request.distance_max = wanted["distance_max_m"].as<double>();
  const cv::Mat image = cv::imread((scene / "image.png").string(), cv::IMREAD_UNCHANGED);
  const Camera camera = loadCamera((scene / "camera_info.yaml").string());
  judge(Locator().locate(image, camera, request).detections,
        truthOf((scene / "ground_truth.yaml").string()), request, sums);
}

void print(const Sums& sums) {
  std::printf(
      "correct detections: %d\n\n| | mean normalised squared error / dimension |\n|---|---|\n",
      sums.correct);
  for (int k = 0; k < 4; ++k) {
    std::printf("| %s | %.2f |\n", kKinds[k], sums.nees[k] / sums.correct / kDimensions[k]);
  }
  std::printf("\nvisible fraction: mean absolute error %.3f\n\n", sums.visible / sums.correct);
  std::printf("| threshold | precision | recall of pickable parts |\n|---|---|---|\n");
  for (double threshold = 0.4; threshold < 0.96; threshold += 0.05) {
    int all = 0, right = 0;
    for (const auto& [score, correct] : sums.scores) {
      if (score < threshold) continue;
      ++all;
      right += correct ? 1 : 0;
    }
    const auto found = std::count_if(sums.found.begin(), sums.found.end(),
                                     [&](double score) { return score >= threshold; });
    std::printf("| %.2f | %.3f | %.3f |\n", threshold, right / std::max(1.0, 1.0 * all),
                static_cast<double>(found) / std::max(1, sums.pickable));
  }
  printReliability(sums.scores);
}

int run(std::vector<std::string> folders) {
  if (folders.empty()) folders = {PACKAGE_DIR "/../shared/scenes"};
  Sums sums;
  for (const std::filesystem::path folder : folders) {
    if (!std::filesystem::is_directory(folder / "open")) {
      std::printf("no scenes at %s: nothing to measure\n", folder.c_str());
      continue;
    }
    std::vector<std::filesystem::path> scenes;
    for (const auto& entry : std::filesystem::directory_iterator(folder / "open")) {
      scenes.push_back(entry.path());
    }
    std::sort(scenes.begin(), scenes.end());
    for (const auto& scene : scenes) runScene(scene, folder / "parts", &sums);
  }
  if (sums.correct > 0) print(sums);
  return 0;
}

}  // namespace
}  // namespace planar_bin_picking

int main(int argc, char** argv) {
  try {
    return planar_bin_picking::run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "honesty: %s\n", error.what());
    return 2;
  }
}
