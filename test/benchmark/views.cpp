// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

/// What a second and a third look are worth, on simulated heaps whose truth is known: errors with
/// one, two and three views, for robots of three kinds; what becomes of first poses that are wrong;
/// and what a look costs. Prints the tables of views.md.
///
///     ./run bench views [--heaps 40] [--megapixels 1.3 5] [--parts bracket ...] [--lights ...]

#include "views_table.h"

#include "base/plane_pose.h"
#include "part/outline_view.h"
#include "planar_bin_picking/locate/locator.h"
#include "planar_bin_picking/views/look.h"
#include "planar_bin_picking/views/next_view.h"
#include "sim/simulated_cell.h"

#include <chrono>
#include <cstring>
#include <map>
#include <random>

namespace planar_bin_picking {
namespace {

constexpr double kHeight = 0.75;   // of the first camera over the bin's floor, metres
constexpr double kVisible = 0.85;  // parts that a robot would be sent to
constexpr std::size_t kPartsPerHeap = 4;
constexpr double kDegree = EIGEN_PI / 180.0;
/// What a suction cup bears: beyond, the first pick fails.
constexpr double kPickDepthMm = 5.0, kPickTiltDeg = 5.0;
constexpr double kCorrectMm = 1.5, kCorrectDeg = 1.5;  // a pose that is right after all

struct Noise {
  const char* name;
  double metres, degrees;  // per axis: of the robot at each stop, and of the hand-eye transform
};
constexpr Noise kNoises[] = {
    {"exact", 0.0, 0.0}, {"0.05 mm, 0.01 deg", 0.05e-3, 0.01}, {"0.2 mm, 0.03 deg", 0.2e-3, 0.03}};

struct Options {
  int heaps = 40, wrong = 200;
  bool trace = false;  ///< each look on stderr
  std::vector<double> megapixels = {1.3, 5.0};
  std::vector<std::string> parts = {"bracket", "linkarm", "sprocket", "hinge", "block"};
  std::vector<std::string> lights = {"diffuse", "ring", "side"};
};

/// As the simulated cell's node has it: the bin fills the picture.
cell::Lens lensOf(double megapixels, const cell::Bin& bin) {
  cell::Lens lens;
  if (megapixels > 3.0) lens.width = 2448, lens.height = 2048;
  const double top = kHeight - bin.height;
  lens.fx =
      std::min(lens.width * top / (1.12 * bin.length), lens.height * top / (1.12 * bin.width));
  lens.fy = 0.9995 * lens.fx;
  lens.cx = 0.5 * lens.width - 11.3;
  lens.cy = 0.5 * lens.height + 7.6;
  lens.d = {-0.092, 0.061, -2.8e-4, -3.1e-4, 0.0};
  return lens;
}

Camera cameraOf(const cell::Lens& lens) {
  Camera::Model model;
  model.width = lens.width;
  model.height = lens.height;
  model.fx = lens.fx;
  model.fy = lens.fy;
  model.cx = lens.cx;
  model.cy = lens.cy;
  model.distortion.assign(lens.d.begin(), lens.d.end());
  return Camera(model);
}

Eigen::Isometry3d shaken(const Noise& noise, std::mt19937* random) {
  std::normal_distribution<double> normal;
  Vector6d xi;
  for (int i = 0; i < 6; ++i)
    xi(i) = (i < 3 ? noise.metres : noise.degrees * kDegree) * normal(*random);
  return exp(xi);
}

LocatorParams paramsOf(const Noise& noise) {
  LocatorParams params;
  params.views.robot_sigma = params.views.hand_eye_sigma = noise.metres;
  params.views.robot_sigma_deg = params.views.hand_eye_sigma_deg = noise.degrees;
  return params;
}

/// Errors by what is printed in one row: "5 Mpx, exact, 2 views".
struct Tally {
  std::map<std::string, std::vector<PoseError>> errors;
  std::map<std::string, int> statuses;
  std::map<std::string, int> wrong;
  std::vector<double> look_ms;
  int failed_first = 0, failed_second = 0, picks = 0;
};

class Heap {
 public:
  Heap(const Options& options, const std::string& part, const std::string& light, double megapixels)
      : options_(options), name_(part), megapixels_(megapixels) {
    const std::string yaml = std::string(PACKAGE_DIR) + "/test/data/parts/" + part + ".yaml";
    part_ = std::make_shared<const PartModel>(loadPartFile(yaml));
    kind_ = cell::loadPartKind(yaml);
    config_.light = light;
    config_.counts = {20};
    config_.lens = lensOf(megapixels, config_.bin);
    cell_ = std::make_unique<cell::SimulatedCell>(config_, std::vector<cell::PartKind>{kind_});
  }

  void run(int seed, Tally* tally, int* wrong_left);

 private:
  struct Found {
    Detection detection;
    Eigen::Isometry3d T_first_true;
    std::vector<Eigen::Isometry3d> twins;
  };
  std::vector<Found> locate(const cv::Mat& image, const Camera& camera) const;
  void record(const Found& found, const std::string& robot, std::size_t views,
              const LookResult& result, Tally* tally) const;
  void lookAll(const std::vector<Found>& found, const std::vector<cv::Mat>& images,
               const std::vector<Eigen::Isometry3d>& places, const Camera& camera,
               std::mt19937* random, Tally* tally);
  void lookWrong(const Found& found, const cv::Mat& first, const cv::Mat& second,
                 const Eigen::Isometry3d& place, const Camera& camera, std::mt19937* random,
                 Tally* tally) const;

  const Options& options_;
  std::string name_;
  double megapixels_;
  PartPtr part_;
  cell::PartKind kind_;
  cell::CellConfig config_;
  std::unique_ptr<cell::SimulatedCell> cell_;
  Eigen::Isometry3d T_base_first_ = Eigen::Translation3d(0.0, 0.0, kHeight) *
                                    Eigen::AngleAxisd(EIGEN_PI, Eigen::Vector3d::UnitX());
};

std::vector<Heap::Found> Heap::locate(const cv::Mat& image, const Camera& camera) const {
  LocateRequest request;
  request.parts = {part_};
  request.distance_min = kHeight - config_.bin.height;
  request.distance_max = kHeight + 0.01;
  const auto result = Locator().locate(image, camera, request);
  std::vector<Found> out;
  for (const Detection& d : result.detections) {
    if (d.visible_fraction < kVisible) continue;
    double least = 0.02;  // farther off, it is a false detection: another bench counts these
    Found found{d, {}, {}};
    for (const cell::TruePart& truth : cell_->truth(T_base_first_)) {
      if (truth.front_up != (d.face == Face::kFront) && kind_.twins.size() < 2) continue;
      const Eigen::Isometry3d T = T_base_first_.inverse() * truth.T_base_part;
      const auto& twins = truth.front_up ? kind_.twins : kind_.back_twins;
      const Eigen::Vector3d centre(part_->center().x(), part_->center().y(), 0.0);
      for (const auto& twin : twins) {
        const double off = (T * twin * centre - d.T_camera_part * centre).norm();
        if (off >= least) continue;
        least = off;
        found.T_first_true = T;
        found.twins = twins;
      }
    }
    if (!found.twins.empty() && out.size() < kPartsPerHeap) out.push_back(found);
  }
  return out;
}

void Heap::record(const Found& found, const std::string& robot, std::size_t views,
                  const LookResult& result, Tally* tally) const {
  const PoseError before = errorOf(found.detection, *part_, found.T_first_true, found.twins);
  const PoseError now = errorOf(result.detection, *part_, found.T_first_true, found.twins);
  const bool counts = result.detection.views == static_cast<int>(views);
  if (options_.trace) {
    std::fprintf(stderr,
                 "%s, %s, view %zu: %s, depth %.2f mm, tilt %.2f deg (before %.2f, %.2f): %s\n",
                 name_.c_str(), robot.c_str(), views, nameOf(result.status), now.depth_mm,
                 now.tilt_deg, before.depth_mm, before.tilt_deg, result.text.c_str());
  }
  if (views == 2) {
    const auto fails = [](const PoseError& e) {
      return e.depth_mm > kPickDepthMm || e.tilt_deg > kPickTiltDeg;
    };
    ++tally->statuses[robot + " | " + nameOf(result.status)];
    ++tally->picks;
    tally->failed_first += fails(before) ? 1 : 0;
    tally->failed_second += counts && fails(now) ? 1 : 0;
  }
  if (counts) tally->errors[robot + " | " + std::to_string(views)].push_back(now);
}

void Heap::lookAll(const std::vector<Found>& found, const std::vector<cv::Mat>& images,
                   const std::vector<Eigen::Isometry3d>& places, const Camera& camera,
                   std::mt19937* random, Tally* tally) {
  char picture[20];
  std::snprintf(picture, sizeof picture, "%.1f Mpx", megapixels_);
  for (const Found& f : found) {
    tally->errors[std::string(picture) + " | - | 1"].push_back(
        errorOf(f.detection, *part_, f.T_first_true, f.twins));
  }
  for (const Noise& noise : kNoises) {
    // The robot says where it thinks that it is; all poses are seen from the first such place.
    const Eigen::Isometry3d hand_eye = shaken(noise, random), first = shaken(noise, random);
    std::vector<ViewPtr> views;
    for (std::size_t k = 0; k < places.size(); ++k) {
      const Eigen::Isometry3d said =
          k == 0 ? places[0]
                 : hand_eye.inverse() * first * places[k] * shaken(noise, random) * hand_eye;
      views.push_back(std::make_shared<const View>(images[k], camera, said));
    }
    const Looker looker(paramsOf(noise));
    const std::string robot = std::string(picture) + " | " + noise.name;
    for (const Found& f : found) {
      TrackedPart tracked{f.detection, {views[0]}};
      for (std::size_t k = 1; k < views.size(); ++k) {
        const auto start = std::chrono::steady_clock::now();
        const LookResult result = looker.look(*part_, views[k], &tracked);
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
        if (k == 1 && megapixels_ > 3.0) tally->look_ms.push_back(1e3 * seconds.count());
        record(f, robot, k + 1, result, tally);
        if (tracked.views.size() != k + 1) break;
      }
    }
  }
}

/// First poses in a wrong depth, of the wrong tilt, on a neighbour's edge.
void Heap::lookWrong(const Found& found, const cv::Mat& first, const cv::Mat& second,
                     const Eigen::Isometry3d& place, const Camera& camera, std::mt19937* random,
                     Tally* tally) const {
  const std::vector<ViewPtr> views = {
      std::make_shared<const View>(first, camera, Eigen::Isometry3d::Identity()),
      std::make_shared<const View>(second, camera, place)};
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  const Eigen::Isometry3d T_part_centre = centreOf(*part_, found.detection.face);
  const Eigen::Isometry3d T = found.detection.T_camera_part * T_part_centre;
  const auto judge = [&](const char* kind, const Eigen::Isometry3d& T_wrong) {
    Detection wrong = found.detection;
    wrong.T_camera_part = T_wrong * T_part_centre.inverse();
    const LookResult result = Looker(paramsOf(kNoises[1])).look(wrong, *part_, views);
    const PoseError error = errorOf(result.detection, *part_, found.T_first_true, found.twins);
    const bool right = error.depth_mm < kCorrectMm && error.tilt_deg < kCorrectDeg &&
                       error.lateral_mm < kCorrectMm;
    std::string outcome = nameOf(result.status);
    if (result.status == LookStatus::kConfirmed || result.status == LookStatus::kCorrected ||
        result.status == LookStatus::kMoved)
      outcome += right ? ", right" : ", wrong";
    ++tally->wrong[std::string(kind) + " | " + outcome];
  };
  Eigen::Isometry3d deep = T;
  const double side = any(*random) > 0.0 ? 1.0 : -1.0;
  deep.translation() *= 1.0 + side * (8.5e-3 + 3.5e-3 * any(*random)) / T.translation().norm();
  judge("depth by 5 to 12 mm", deep);
  const Eigen::Vector2d p = T.translation().hnormalized();
  Eigen::Matrix<double, 2, 3> project;
  project << 1, 0, -p.x(), 0, 1, -p.y();
  const auto planes = posesFromAffine(project * T.linear().leftCols<2>() / T.translation().z(), p);
  for (const Eigen::Isometry3d& plane : planes) {
    if ((plane.linear() - T.linear()).norm() > 0.1) judge("the other tilt", plane);
  }
  Eigen::Isometry3d beside = T;
  const double angle = EIGEN_PI * any(*random);
  beside.translation() +=
      (4e-3 + 2e-3 * any(*random)) * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0);
  judge("beside by 2 to 6 mm", beside);
}

void Heap::run(int seed, Tally* tally, int* wrong_left) {
  cell_->refill(static_cast<std::uint64_t>(seed));
  std::mt19937 random(static_cast<unsigned>(seed));
  const Camera camera = cameraOf(config_.lens);
  const double exposure = cell_->exposureFor(T_base_first_);
  const cv::Mat first = cell_->takePicture(T_base_first_, exposure);
  const auto found = locate(first, camera);
  if (found.empty()) return;
  // Where the program says, for the best part; the others are looked at from there, too.
  NextViewLimits limits;
  limits.box_min = {-0.8, -0.8, 0.3};
  limits.box_max = {0.8, 0.8, 0.85};
  limits.cone_deg = 35.0;
  limits.focus = {0.45, 0.85};
  const cell::Bin& bin = config_.bin;
  limits.bin = ViewBin{Eigen::Isometry3d::Identity(),
                       {-0.5 * bin.length, -0.5 * bin.width, 0.0},
                       {0.5 * bin.length, 0.5 * bin.width, bin.height}};
  const LocatorParams params = paramsOf(kNoises[1]);
  std::vector<Eigen::Isometry3d> places{Eigen::Isometry3d::Identity()};
  std::vector<cv::Mat> images{first};
  Detection known = found[0].detection;
  for (int k = 0; k < 2; ++k) {
    const auto next = nextView(known, *part_, camera, T_base_first_, limits, params);
    if (!next) break;
    places.push_back(next->T_first_camera);
    const Eigen::Isometry3d T_base_camera = T_base_first_ * next->T_first_camera;
    images.push_back(cell_->takePicture(T_base_camera, exposure));
    known.covariance = next->covariance;
  }
  if (places.size() < 2) return;
  lookAll(found, images, places, camera, &random, tally);
  if (*wrong_left > 0) {
    lookWrong(found[0], images[0], images[1], places[1], camera, &random, tally);
    *wrong_left -= 3;
  }
}

Options parse(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const auto values = [&] {
      std::vector<std::string> out;
      while (i + 1 < argc && std::strncmp(argv[i + 1], "--", 2) != 0) out.push_back(argv[++i]);
      return out;
    };
    const std::string option = argv[i];
    if (option == "--heaps") {
      options.heaps = std::stoi(values().at(0));
    } else if (option == "--trace") {
      options.trace = true;
    } else if (option == "--parts") {
      options.parts = values();
    } else if (option == "--lights") {
      options.lights = values();
    } else if (option == "--megapixels") {
      options.megapixels.clear();
      for (const auto& value : values()) options.megapixels.push_back(std::stod(value));
    } else {
      throw std::invalid_argument("views: no option " + option);
    }
  }
  return options;
}

void print(const Tally& tally) {
  std::printf(
      "| picture | robot and hand-eye | views | poses | depth mm | tilt deg | lateral mm | "
      "squared |\n|---|---|---|---|---|---|---|---|\n");
  for (const auto& [name, errors] : tally.errors) printRow(name, errors);
  std::printf("\n| picture | robot and hand-eye | second look | poses |\n|---|---|---|---|\n");
  for (const auto& [name, count] : tally.statuses)
    std::printf("| %s | %d |\n", name.c_str(), count);
  std::printf("\n| first pose wrong | the look says | poses |\n|---|---|---|\n");
  for (const auto& [name, count] : tally.wrong) std::printf("| %s | %d |\n", name.c_str(), count);
  std::printf(
      "\nOf %d poses %d would fail by depth or tilt with one view, %d with two. One look at 5 "
      "Mpx: median %.1f ms, largest %.1f ms.\n",
      tally.picks, tally.failed_first, tally.failed_second, quantile(tally.look_ms, 0.5),
      quantile(tally.look_ms, 1.0));
}

int runAll(int argc, char** argv) {
  const Options options = parse(argc, argv);
  Tally tally;
  int wrong_left = options.wrong;
  for (const double megapixels : options.megapixels) {
    for (const auto& part : options.parts) {
      for (const auto& light : options.lights) {
        Heap heap(options, part, light, megapixels);
        for (int seed = 1; seed <= options.heaps; ++seed) heap.run(seed, &tally, &wrong_left);
        std::fprintf(stderr, "%.1f Mpx, %s, %s\n", megapixels, part.c_str(), light.c_str());
      }
    }
  }
  print(tally);
  return 0;
}

}  // namespace
}  // namespace planar_bin_picking

int main(int argc, char** argv) {
  try {
    return planar_bin_picking::runAll(argc, argv);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 1;
  }
}
