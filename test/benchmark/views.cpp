// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

/// What a second and a third look are worth, on simulated heaps whose truth is known: errors with
/// one, two and three views, for robots of three kinds; what becomes of first poses that are wrong;
/// and what a look costs. Prints the tables of views.md.
///
///     ./run bench views [--heaps 40] [--seed 1] [--minutes M] [--megapixels 1.3 5]
///                       [--parts bracket ...] [--lights ...] [--cone 45] [--wrong 5] [--trace]
///
/// Every heap is poured and its pictures are taken once, for all robots; nothing is written to
/// disk. The heaps go round the parts and lights, so that a run that --minutes ends has seen all.

#include "views_heap.h"
#include "views_table.h"

#include "base/plane_pose.h"
#include "planar_bin_picking/views/look.h"
#include "support/orbit.h"

#include <chrono>
#include <cstring>
#include <map>
#include <random>

namespace planar_bin_picking {
namespace {

/// What a suction cup bears: beyond, the first pick fails.
constexpr double kPickDepthMm = 5.0, kPickTiltDeg = 5.0;
constexpr double kCorrectMm = 1.5, kCorrectDeg = 1.5;  // a pose that is right after all

struct Robot {
  const char* name;
  double metres, degrees;  // per axis: of the robot at each stop, and of the hand-eye transform
};
constexpr Robot kRobots[] = {
    {"exact", 0.0, 0.0}, {"0.05 mm, 0.01 deg", 0.05e-3, 0.01}, {"0.2 mm, 0.03 deg", 0.2e-3, 0.03}};
constexpr const Robot& kBetter = kRobots[1];

struct Options {
  int heaps = 40, seed = 1;
  int wrong = 5;           ///< heaps of each kind in whose pictures wrong first poses are looked at
  double minutes = 0.0;    ///< 0 = all heaps
  double cone_deg = 45.0;  ///< as the calibrator's
  bool trace = false;      ///< each look on stderr
  std::vector<double> megapixels = {1.3, 5.0};
  std::vector<std::string> parts = {"bracket", "linkarm", "sprocket", "hinge", "block"};
  std::vector<std::string> lights = {"diffuse", "ring", "side"};
};

LocatorParams paramsOf(const Robot& robot) {
  LocatorParams params;
  params.views.robot_sigma = params.views.hand_eye_sigma = robot.metres;
  params.views.robot_sigma_deg = params.views.hand_eye_sigma_deg = robot.degrees;
  return params;
}

/// Everything that is counted, by the first cells of the row that it is printed in.
struct Tally {
  std::map<std::string, std::vector<PoseError>> errors;
  std::map<std::string, int> statuses, wrong, heaps;
  std::vector<double> look_ms;
  int failed_first = 0, failed_second = 0, picks = 0;
};

std::string pictureOf(const HeapKind& kind) {
  char picture[20];
  std::snprintf(picture, sizeof picture, "%.1f Mpx", kind.megapixels);
  return picture;
}

class HeapLooks {
 public:
  HeapLooks(const ViewedHeap& heap, const HeapPictures& pictures, bool trace, Tally* tally)
      : heap_(heap), pictures_(pictures), trace_(trace), tally_(tally) {}

  void lookAll(std::mt19937* random);
  void lookWrong(std::mt19937* random);

 private:
  PoseError errorOfFound(const FoundPart& found, const Detection& now) const {
    return errorOf(now, heap_.part(), found.T_first_true, found.symmetric_poses);
  }
  void record(const FoundPart& found, const std::string& robot, std::size_t views,
              const LookResult& result);
  void judgeWrong(const char* kind, const Eigen::Isometry3d& T_wrong,
                  const std::vector<ViewPtr>& views);

  const ViewedHeap& heap_;
  const HeapPictures& pictures_;
  const bool trace_;
  Tally* const tally_;
};

void HeapLooks::record(const FoundPart& found, const std::string& robot, std::size_t views,
                       const LookResult& result) {
  const PoseError before = errorOfFound(found, found.detection);
  const PoseError now = errorOfFound(found, result.detection);
  const bool counts = result.detection.views == static_cast<int>(views);
  if (trace_) {
    std::fprintf(stderr,
                 "%s, %s, %s, view %zu: %s, depth %.2f mm, tilt %.2f deg (%.2f, %.2f): %s\n",
                 heap_.kind().part.c_str(), heap_.kind().light.c_str(), robot.c_str(), views,
                 nameOf(result.status), now.depth_mm, now.tilt_deg, before.depth_mm,
                 before.tilt_deg, result.text.c_str());
  }
  if (views == 2) {
    const auto fails = [](const PoseError& e) {
      return e.depth_mm > kPickDepthMm || e.tilt_deg > kPickTiltDeg;
    };
    ++tally_->statuses[robot + " | " + nameOf(result.status)];
    ++tally_->picks;
    tally_->failed_first += fails(before) ? 1 : 0;
    tally_->failed_second += counts && fails(now) ? 1 : 0;
  }
  if (counts) tally_->errors[robot + " | " + std::to_string(views)].push_back(now);
}

void HeapLooks::lookAll(std::mt19937* random) {
  const std::string picture = pictureOf(heap_.kind());
  for (const FoundPart& f : pictures_.found)
    tally_->errors[picture + " | - | 1"].push_back(errorOfFound(f, f.detection));
  const Eigen::Isometry3d same = Eigen::Isometry3d::Identity();
  for (const Robot& noise : kRobots) {
    const auto anew = [&] { return shaken(same, noise.metres, noise.degrees, random); };
    // The robot says where it thinks that it is; all poses are seen from the first such place.
    const Eigen::Isometry3d hand_eye = anew(), first = anew();
    std::vector<ViewPtr> views;
    for (std::size_t k = 0; k < pictures_.images.size(); ++k) {
      const Eigen::Isometry3d& T = pictures_.T_first_view[k];
      const Eigen::Isometry3d said =
          k == 0 ? T : hand_eye.inverse() * first * T * anew() * hand_eye;
      views.push_back(std::make_shared<const View>(pictures_.images[k], heap_.camera(), said));
    }
    const Looker looker(paramsOf(noise));
    for (const FoundPart& f : pictures_.found) {
      TrackedPart tracked{f.detection, {views[0]}};
      for (std::size_t k = 1; k < views.size(); ++k) {
        const auto start = std::chrono::steady_clock::now();
        const LookResult result = looker.look(heap_.part(), views[k], &tracked);
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
        if (k == 1 && heap_.kind().megapixels > 3.0)
          tally_->look_ms.push_back(1e3 * seconds.count());
        record(f, picture + " | " + noise.name, k + 1, result);
        if (tracked.views.size() != k + 1) break;
      }
    }
  }
}

void HeapLooks::judgeWrong(const char* kind, const Eigen::Isometry3d& T_wrong,
                           const std::vector<ViewPtr>& views) {
  const FoundPart& found = pictures_.found.front();
  Detection wrong = found.detection;
  wrong.T_camera_part = T_wrong * centreOf(heap_.part(), wrong.face).inverse();
  const LookResult result = Looker(paramsOf(kBetter)).look(wrong, heap_.part(), views);
  const PoseError error = errorOfFound(found, result.detection);
  const bool right =
      error.depth_mm < kCorrectMm && error.tilt_deg < kCorrectDeg && error.lateral_mm < kCorrectMm;
  std::string outcome = nameOf(result.status);
  if (result.status != LookStatus::kContradicted && result.status != LookStatus::kNotSeen)
    outcome += right ? ", right" : ", wrong";
  if (trace_) {
    std::fprintf(stderr, "%s, %s, wrong %s: %s; depth %.2f, lateral %.2f mm, tilt %.2f deg: %s\n",
                 heap_.kind().part.c_str(), heap_.kind().light.c_str(), kind, outcome.c_str(),
                 error.depth_mm, error.lateral_mm, error.tilt_deg, result.text.c_str());
  }
  ++tally_->wrong[pictureOf(heap_.kind()) + " | " + kind + " | " + outcome];
}

/// First poses in a wrong depth, of the wrong tilt, on a neighbour's edge.
void HeapLooks::lookWrong(std::mt19937* random) {
  std::vector<ViewPtr> views;
  for (std::size_t k = 0; k < 2; ++k) {
    views.push_back(std::make_shared<const View>(pictures_.images[k], heap_.camera(),
                                                 pictures_.T_first_view[k]));
  }
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  const Detection& known = pictures_.found.front().detection;
  const Eigen::Isometry3d T = known.T_camera_part * centreOf(heap_.part(), known.face);
  Eigen::Isometry3d deep = T;
  const double side = any(*random) > 0.0 ? 1.0 : -1.0;
  deep.translation() *= 1.0 + side * (8.5e-3 + 3.5e-3 * any(*random)) / T.translation().norm();
  judgeWrong("depth by 5 to 12 mm", deep, views);
  const Eigen::Vector2d p = T.translation().hnormalized();
  Eigen::Matrix<double, 2, 3> project;
  project << 1, 0, -p.x(), 0, 1, -p.y();
  const auto planes = posesFromAffine(project * T.linear().leftCols<2>() / T.translation().z(), p);
  for (const Eigen::Isometry3d& plane : planes) {
    if ((plane.linear() - T.linear()).norm() > 0.1) judgeWrong("the other tilt", plane, views);
  }
  Eigen::Isometry3d beside = T;
  const double angle = EIGEN_PI * any(*random);
  beside.translation() +=
      (4e-3 + 2e-3 * any(*random)) * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0);
  judgeWrong("beside by 2 to 6 mm", beside, views);
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
    } else if (option == "--seed") {
      options.seed = std::stoi(values().at(0));
    } else if (option == "--wrong") {
      options.wrong = std::stoi(values().at(0));
    } else if (option == "--minutes") {
      options.minutes = std::stod(values().at(0));
    } else if (option == "--cone") {
      options.cone_deg = std::stod(values().at(0));
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

void printCounts(const char* head, const std::map<std::string, int>& counts) {
  std::printf("\n%s\n", head);
  for (const auto& [name, count] : counts) std::printf("| %s | %d |\n", name.c_str(), count);
}

void print(const Tally& tally) {
  std::printf(
      "| picture | robot and hand-eye | views | poses | depth mm | tilt deg | lateral mm | depth² "
      "| "
      "lateral² | tilt² | turn² | expected depth |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const auto& [name, errors] : tally.errors) printRow(name, errors);
  printCounts("| picture | robot and hand-eye | second look | poses |\n|---|---|---|---|",
              tally.statuses);
  printCounts("| picture | first pose wrong | the look says | poses |\n|---|---|---|---|",
              tally.wrong);
  printCounts("| picture | heaps |\n|---|---|", tally.heaps);
  std::printf(
      "\nOf %d poses %d would fail by depth or tilt with one view, %d with two. One look at 5 "
      "Mpx: median %.1f ms, largest %.1f ms.\n",
      tally.picks, tally.failed_first, tally.failed_second, quantile(tally.look_ms, 0.5),
      quantile(tally.look_ms, 1.0));
}

void runHeap(int seed, const Options& options, ViewedHeap* heap, Tally* tally) {
  const HeapPictures pictures = heap->pour(seed, paramsOf(kBetter));
  ++tally->heaps[pictureOf(heap->kind())];
  if (pictures.images.size() < 2) return;
  std::mt19937 random(static_cast<unsigned>(seed));
  HeapLooks looks(*heap, pictures, options.trace, tally);
  looks.lookAll(&random);
  if (seed - options.seed < options.wrong) looks.lookWrong(&random);
}

int runAll(int argc, char** argv) {
  const Options options = parse(argc, argv);
  std::vector<std::unique_ptr<ViewedHeap>> heaps;
  for (const double megapixels : options.megapixels)
    for (const auto& part : options.parts)
      for (const auto& light : options.lights)
        heaps.push_back(
            std::make_unique<ViewedHeap>(HeapKind{part, light, megapixels, options.cone_deg}));
  Tally tally;
  const auto start = std::chrono::steady_clock::now();
  const auto minutes = [&start] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() / 60.0;
  };
  for (int seed = options.seed; seed < options.seed + options.heaps; ++seed) {
    for (const auto& heap : heaps) {
      if (options.minutes > 0.0 && minutes() > options.minutes) break;
      runHeap(seed, options, heap.get(), &tally);
    }
    std::fprintf(stderr, "heaps of seed %d: %.1f minutes\n", seed, minutes());
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
