// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/calibrate/sample_folder.h"

#include "base/atomic_file.h"
#include "base/yaml_file.h"
#include "planar_bin_picking/calibrate/board/board_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <locale>
#include <sstream>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

namespace fs = std::filesystem;

const char kPictures[] = "samples", kSamples[] = "samples.yaml", kCorners[] = "corners.yaml";
const char kEarlier[] = "earlier_samples";

/// Numbers have points, whatever the process's locale.
std::ostringstream classicText() {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << std::setprecision(10);
  return text;
}

std::string listOf(const std::vector<double>& values) {
  std::ostringstream text = classicText();
  for (std::size_t i = 0; i < values.size(); ++i) text << (i == 0 ? "[" : ", ") << values[i];
  return text.str() + "]";
}

std::string poseText(const Observation& observation) {
  const Eigen::Vector3d p = observation.T_base_flange.translation();
  const Eigen::Quaterniond q(observation.T_base_flange.linear());
  return "image: " + observation.name + ", position: " + listOf({p.x(), p.y(), p.z()}) +
         ", orientation: " + listOf({q.x(), q.y(), q.z(), q.w()});
}

std::string samplesYaml(const SampleSet& set) {
  std::string text = "# Pictures and T_base_flange, metres, for calibrate_samples.\n";
  for (const Observation& observation : set.problem.observations) {
    text += "- {" + poseText(observation) + "}\n";
  }
  return set.problem.observations.empty() ? "[]\n" : text;
}

std::string quoted(const std::string& text) {
  YAML::Emitter out;
  out << YAML::DoubleQuoted << text;
  return out.c_str();
}

std::string cornersYaml(const SampleSet& set) {
  const HandEyeProblem& problem = set.problem;
  std::ostringstream text = classicText();
  text << "mounting: " << (problem.mounting == Mounting::kEyeInHand ? "eye_in_hand" : "eye_to_hand")
       << "\nkind: " << nameOf(problem.board.kind) << "\nboard: " << problem.board.cols << "x"
       << problem.board.rows << "\nsquare: " << problem.board.square << "\nimage_size: ["
       << problem.width << ", " << problem.height
       << "]\ncamera_frame: " << quoted(set.camera_frame);
  if (problem.board.kind == Board::Kind::kCharuco) {
    text << "\nmarker: " << problem.board.marker
         << "\ndictionary: " << quoted(problem.board.dictionary);
  }
  text << "\nsamples:\n";
  for (const Observation& observation : problem.observations) {
    std::vector<double> corners;
    for (const Eigen::Vector2d& p : observation.corners)
      corners.insert(corners.end(), {p.x(), p.y()});
    text << "- {" << poseText(observation) << ", corners: " << listOf(corners);
    if (!observation.ids.empty()) {
      text << ", ids: " << listOf({observation.ids.begin(), observation.ids.end()});
    }
    text << "}\n";
  }
  return text.str();
}

Observation readObservation(const YAML::Node& node, const std::string& where, const Board& board) {
  if (!node.IsMap()) throw std::runtime_error(where + ": is no map");
  refuseUnknownKeys(node, where, {"image", "position", "orientation", "corners", "ids"});
  Observation observation;
  observation.name = valueAs<std::string>(node["image"], where, "image", "the path of a picture");
  observation.T_base_flange = poseIn(node, where);
  if (node["ids"].IsDefined()) {
    const std::string expected = "numbers of the board's corners";
    for (const int id : valueAs<std::vector<int>>(node["ids"], where, "ids", expected)) {
      if (id < 0) throwBadValue(where, "ids", node["ids"], expected);
      observation.ids.push_back(static_cast<std::size_t>(id));
    }
  }
  const std::size_t count = observation.ids.empty() ? board.size() : observation.ids.size();
  const auto corners = numbersAt(node, where, "corners", 2 * count);
  for (std::size_t i = 0; i < corners.size(); i += 2) {
    observation.corners.emplace_back(corners[i], corners[i + 1]);
  }
  return observation;
}

SampleSet readSet(const YAML::Node& root, const std::string& path) {
  refuseUnknownKeys(root, path,
                    {"mounting", "kind", "board", "square", "marker", "dictionary", "image_size",
                     "camera_frame", "samples"});
  SampleSet set;
  HandEyeProblem& problem = set.problem;
  const auto mounting =
      valueAs<std::string>(root["mounting"], path, "mounting", "eye_in_hand or eye_to_hand");
  if (mounting != "eye_in_hand" && mounting != "eye_to_hand") {
    throwBadValue(path, "mounting", root["mounting"], "eye_in_hand or eye_to_hand");
  }
  problem.mounting = mounting == "eye_in_hand" ? Mounting::kEyeInHand : Mounting::kEyeToHand;
  const auto square = valueAs<double>(root["square"], path, "square", "metres");
  problem.board = parseBoard(valueAs<std::string>(root["board"], path, "board", "as 9x6"), square);
  if (root["kind"].IsDefined()) {
    problem.board.kind = parseKind(valueAs<std::string>(root["kind"], path, "kind", "a kind"));
  }
  if (problem.board.kind == Board::Kind::kCharuco) {
    problem.board.marker = valueAs<double>(root["marker"], path, "marker", "metres");
    problem.board.dictionary =
        valueAs<std::string>(root["dictionary"], path, "dictionary", "one of OpenCV's");
  }
  const auto size = numbersAt(root, path, "image_size", 2);
  constexpr double kPixelsMost = 1e5;
  for (const double side : size) {
    if (side >= 1.0 && side <= kPixelsMost && side == std::floor(side)) continue;
    throwBadValue(path, "image_size", root["image_size"], "width and height in pixels");
  }
  problem.width = static_cast<int>(size[0]);
  problem.height = static_cast<int>(size[1]);
  set.camera_frame =
      valueAs<std::string>(root["camera_frame"], path, "camera_frame", "the images' frame");
  for (std::size_t i = 0; i < root["samples"].size(); ++i) {
    problem.observations.push_back(readObservation(
        root["samples"][i], path + ": sample " + std::to_string(i + 1), problem.board));
  }
  return set;
}

void setAside(const fs::path& from, const fs::path& to) {
  std::error_code error;
  if (!fs::exists(from, error)) return;
  fs::rename(from, to, error);
  if (error) {
    throw std::runtime_error(from.string() + ": cannot be moved to " + to.string() + ": " +
                             error.message() + "; move it away, or choose another folder");
  }
}

}  // namespace

void SampleFolder::begin() const {
  const fs::path folder(folder_), earlier = folder / kEarlier;
  std::error_code error;
  if (fs::exists(folder / kCorners, error)) {
    fs::remove_all(earlier, error);
    fs::create_directories(earlier, error);
    // In this order: a set is there as long as its corners.yaml is.
    setAside(folder / kPictures, earlier / kPictures);
    setAside(folder / kSamples, earlier / kSamples);
    setAside(folder / kCorners, earlier / kCorners);
  }
  // Of a set that was begun and has no sample, and copies of what is no more.
  for (const char* const name : {kSamples, kCorners}) {
    fs::remove(folder / (std::string(name) + ".before"), error);
  }
}

std::string SampleFolder::nextName(const SampleSet& set) {
  int last = 0;
  for (const Observation& observation : set.problem.observations) {
    const auto digits = observation.name.find_last_of('_');
    if (digits == std::string::npos) continue;
    last = std::max(last, std::atoi(observation.name.c_str() + digits + 1));
  }
  std::ostringstream name = classicText();
  name << kPictures << "/picture_" << std::setfill('0') << std::setw(3) << last + 1 << ".png";
  return name.str();
}

void SampleFolder::add(const SampleSet& set, const std::string& png) const {
  const std::string at = folder_ + "/";
  std::error_code ignored;  // what is wrong with it shows when something is written into it
  fs::create_directories(at + kPictures, ignored);
  writeTogether({{at + set.problem.observations.back().name, png},
                 {at + kSamples, samplesYaml(set)},
                 {at + kCorners, cornersYaml(set)}});
}

void SampleFolder::remove(const SampleSet& set, const std::string& name) const {
  const std::string at = folder_ + "/";
  writeTogether({{at + kSamples, samplesYaml(set)}, {at + kCorners, cornersYaml(set)}});
  std::error_code ignored;  // a picture more does no harm
  fs::remove(at + name, ignored);
}

SampleSet SampleFolder::load() const {
  const std::string path = folder_ + "/" + kCorners;
  return readSet(loadYamlMap(path), path);
}

}  // namespace planar_bin_picking
