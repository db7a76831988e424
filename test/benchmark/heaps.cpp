// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

/// What is found in simulated heaps of sixteen shapes, whose truth is known; prints the table of
/// README.md's heaps.
///
///     ./run bench heaps [--heaps 2] [--seed 1] [--shapes comb ...] [--megapixels 1.3 5]
///         [--bayer RGGB] [--jpeg-quality 90]
///
/// Lights, metals and picture sizes go round the heaps. Correct is as the scenes' evaluation has
/// it: within 2 mm aside, 8 mm in depth, 2 degrees and 6 degrees of tilt of a part not taken yet.
/// Each heap is also asked for another shape, of which it has none. The second table is how often
/// an answer of a score is right.

#include "heaps_shapes.h"
#include "reliability.h"

#include "planar_bin_picking/locate/locator.h"
#include "sim/simulated_cell.h"
#include "support/dxf_writer.h"
#include "support/temp_dir.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <optional>

namespace planar_bin_picking {
namespace {

constexpr double kHeight = 0.75;  // of the camera over the bin's floor, metres
/// Limits of a correct pose: mm aside, mm in depth, degrees turned, degrees tilted.
constexpr std::array<double, 4> kLimits{2.0, 8.0, 2.0, 6.0};
constexpr std::size_t kOther = 5;  // places on in the list of shapes: the shape not there
/// A part that must be found: so much of it is in view, and it is tilted by no more.
constexpr double kFree = 0.95, kFreeTiltDeg = 40.0;

struct Options {
  int heaps = 2, seed = 1;
  std::vector<std::string> shapes;  ///< empty = all
  std::vector<double> megapixels = {1.3, 5.0};
  cell::Encoding encoding;  ///< of all pictures
};

using Errors = std::array<double, 4>;

struct Tally {
  int heaps = 0, first = 0, returned = 0, correct = 0, free = 0, found = 0;
  std::array<std::vector<double>, 4> errors;
  std::vector<double> ms;
  std::vector<std::pair<double, bool>> scores;  // and whether right
  std::vector<double> foreign;  // highest score for the shape that is not there, 0 if none

  void add(const Tally& other) {
    heaps += other.heaps, first += other.first, returned += other.returned;
    correct += other.correct, free += other.free, found += other.found;
    for (std::size_t k = 0; k < errors.size(); ++k)
      errors[k].insert(errors[k].end(), other.errors[k].begin(), other.errors[k].end());
    ms.insert(ms.end(), other.ms.begin(), other.ms.end());
    scores.insert(scores.end(), other.scores.begin(), other.scores.end());
    foreign.insert(foreign.end(), other.foreign.begin(), other.foreign.end());
  }
};

/// Part file and drawing, as a user would have them; returns the part file's path.
std::string writePart(const TempDir& folder, const HeapShape& shape) {
  DxfWriter drawing;
  const auto add = [&drawing](const sim::Ring& ring) {
    std::vector<std::vector<double>> vertices;
    for (const Eigen::Vector2d& p : ring) vertices.push_back({p.x(), p.y()});
    drawing.polyline(vertices);
  };
  add(shape.plate.outer);
  for (const sim::Ring& ring : shape.plate.holes) add(ring);
  folder.write(shape.name + ".dxf", drawing.text());
  const auto number = [](double value) { return DxfValue(value).text(); };
  const std::string x = number(shape.grasp.x()), y = number(shape.grasp.y());
  const std::string thickness = number(shape.thickness_mm);
  return folder.write(shape.name + ".yaml",
                      "drawing: " + shape.name + ".dxf\nthickness_mm: " + thickness +
                          "\npick_poses:\n" + "  - {name: a, face: front, position_mm: [" + x +
                          ", " + y + ", 0], rpy_deg: [180, 0, 0]}\n" +
                          "  - {name: b, face: back, position_mm: [" + x + ", " + y + ", -" +
                          thickness + "], rpy_deg: [0, 0, 0]}\n");
}

/// Errors at the middle of the face that is up, in the order of kLimits.
Errors errorsOf(const Eigen::Isometry3d& found, const Eigen::Isometry3d& truth, double z) {
  const Eigen::Vector3d face(0.0, 0.0, z), at = truth * face, off = found * face - at;
  const double depth = off.dot(at.normalized());
  const Eigen::Matrix3d R = truth.linear().transpose() * found.linear();
  return {1e3 * (off - depth * at.normalized()).norm(), 1e3 * std::abs(depth),
          std::abs(std::atan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1))) / kDegrees,
          std::acos(std::clamp(R(2, 2), -1.0, 1.0)) / kDegrees};
}

double worstOf(const Errors& errors) {
  double worst = 0.0;
  for (std::size_t k = 0; k < errors.size(); ++k) worst = std::max(worst, errors[k] / kLimits[k]);
  return worst;
}

/// One heap: pours it, takes its picture, and locates.
Tally count(const cell::PartKind& kind, const PartPtr& part, const PartPtr& foreign,
            const cell::CellConfig& config) {
  cell::SimulatedCell bin(config, {kind});
  bin.refill(config.seed);
  Eigen::Isometry3d T_base_camera(Eigen::AngleAxisd(EIGEN_PI, Eigen::Vector3d::UnitX()));
  T_base_camera.translation().z() = kHeight;
  const cv::Mat image = bin.takePicture(T_base_camera, bin.exposureFor(T_base_camera));
  LocateRequest request;
  request.parts = {part};
  request.distance_min = kHeight - config.bin.height;
  request.distance_max = kHeight + 0.01;
  const LocateResult result =
      Locator().locate(image, makeCamera(config.lens, config.lens.d), request);

  Tally out;
  out.heaps = 1;
  out.ms = {1e3 * result.report.seconds};
  request.parts = {foreign};
  const auto false_ones =
      Locator().locate(image, makeCamera(config.lens, config.lens.d), request).detections;
  out.foreign = {false_ones.empty() ? 0.0 : false_ones.front().score};
  const auto truth = bin.truth(T_base_camera);
  std::vector<bool> taken(truth.size(), false);
  for (const Detection& d : result.detections) {
    std::optional<Errors> best;
    std::size_t best_part = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const Eigen::Isometry3d T = T_base_camera.inverse() * truth[i].T_base_part;
      const double z = truth[i].front_up ? 0.0 : -part->thickness();
      for (const auto& T_part_same :
           truth[i].front_up ? kind.symmetric_poses : kind.back_symmetric_poses) {
        const Errors errors = errorsOf(d.T_camera_part * T_part_same, T, z);
        if (taken[i] || (best && worstOf(errors) >= worstOf(*best))) continue;
        best = errors;
        best_part = i;
      }
    }
    const bool correct = best && worstOf(*best) <= 1.0;
    if (out.returned++ == 0 && correct) ++out.first;
    out.scores.emplace_back(d.score, correct);
    if (!correct) continue;
    ++out.correct;
    taken[best_part] = true;
    for (std::size_t k = 0; k < best->size(); ++k) out.errors[k].push_back((*best)[k]);
  }
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const Eigen::Isometry3d T = T_base_camera.inverse() * truth[i].T_base_part;
    const double tilt = std::acos(std::min(1.0, std::abs(T.linear()(2, 2)))) / kDegrees;
    if (truth[i].visible_fraction < kFree || tilt > kFreeTiltDeg) continue;
    ++out.free;
    out.found += taken[i];
  }
  return out;
}

void print(const std::string& name, const Tally& t) {
  const auto cells = [](std::vector<double> values, int digits = 2) {
    if (values.empty()) return std::string("-");
    std::sort(values.begin(), values.end());
    char text[32];
    std::snprintf(text, sizeof text, "%.*f / %.*f", digits, values[values.size() / 2], digits,
                  values.back());
    return std::string(text);
  };
  std::printf("| %s | %d of %d | %d / %d | %d / %d | %s | %s | %s | %s | %s |\n", name.c_str(),
              t.first, t.heaps, t.correct, t.returned, t.found, t.free, cells(t.errors[0]).c_str(),
              cells(t.errors[1]).c_str(), cells(t.errors[2]).c_str(), cells(t.errors[3]).c_str(),
              cells(t.ms, 0).c_str());
  std::fflush(stdout);
}

void run(const Options& options) {
  constexpr const char* kLights[] = {"diffuse", "ring", "side"};
  constexpr const char* kMetals[] = {"rolled", "brushed", "painted"};
  std::printf(
      "| shape | first right | correct / returned | found / free | aside mm | depth mm | "
      "turn deg | tilt deg | ms |\n|---|---|---|---|---|---|---|---|---|\n");
  const TempDir folder;
  Tally all;
  const auto shapes = heapShapes();
  for (std::size_t s = 0; s < shapes.size(); ++s) {
    const HeapShape& shape = shapes[s];
    const auto& asked = options.shapes;
    if (!asked.empty() && std::find(asked.begin(), asked.end(), shape.name) == asked.end())
      continue;
    const std::string file = writePart(folder, shape);
    const cell::PartKind kind = cell::loadPartKind(file);
    const auto part = std::make_shared<const PartModel>(loadPartFile(file));
    const auto foreign = std::make_shared<const PartModel>(
        loadPartFile(writePart(folder, shapes[(s + kOther) % shapes.size()])));
    Tally tally;
    for (int h = 0; h < options.heaps; ++h) {
      cell::CellConfig config;
      config.counts = {shape.count};
      config.light = kLights[(s + h) % 3];
      config.material = kMetals[(s / 3 + h) % 3];
      config.seed = static_cast<std::uint64_t>(options.seed + 100 * h) + 1000 * s;
      config.sensor.encoding = options.encoding;
      config.lens = cell::lensOver(config.bin, kHeight,
                                   options.megapixels[(s + h) % options.megapixels.size()]);
      tally.add(count(kind, part, foreign, config));
    }
    print(shape.name, tally);
    all.add(tally);
  }
  print("all", all);
  const auto answered =
      std::count_if(all.foreign.begin(), all.foreign.end(), [](double s) { return s > 0.0; });
  std::printf("\nasked for another shape: %td of %zu heaps answered, highest score %.2f\n",
              answered, all.foreign.size(),
              *std::max_element(all.foreign.begin(), all.foreign.end()));
  printReliability(all.scores);
}

Options parse(int argc, char** argv) {
  Options out;
  for (int i = 1; i < argc;) {
    const std::string name = argv[i++];
    std::vector<std::string> values;
    while (i < argc && std::strncmp(argv[i], "--", 2) != 0) values.push_back(argv[i++]);
    if (values.empty()) throw std::invalid_argument(name + " needs a value");
    if (name == "--heaps") {
      out.heaps = std::stoi(values[0]);
    } else if (name == "--seed") {
      out.seed = std::stoi(values[0]);
    } else if (name == "--shapes") {
      out.shapes = values;
    } else if (name == "--bayer") {
      out.encoding.bayer = values[0];
    } else if (name == "--jpeg-quality") {
      out.encoding.jpeg_quality = std::stoi(values[0]);
    } else if (name == "--megapixels") {
      out.megapixels.clear();
      for (const auto& value : values) out.megapixels.push_back(std::stod(value));
    } else {
      throw std::invalid_argument("unknown option " + name);
    }
  }
  check(out.encoding);
  return out;
}

}  // namespace
}  // namespace planar_bin_picking

int main(int argc, char** argv) {
  try {
    planar_bin_picking::run(planar_bin_picking::parse(argc, argv));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "heaps: %s\n", error.what());
    return 2;
  }
  return 0;
}
