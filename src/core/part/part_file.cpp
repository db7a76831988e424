// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/part/part_file.h"

#include "base/yaml_file.h"
#include "part/pick_check.h"
#include "planar_bin_picking/drawing/drawing_file.h"

#include <dirent.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <memory>
#include <set>
#include <stdexcept>
#include <system_error>

namespace planar_bin_picking {
namespace {

constexpr std::size_t kPosesMost = 200;      // each is compared with the copies of all others
constexpr std::size_t kLayersMost = 1000;    // each entity is compared with all of them
constexpr double kMillimetresMost = 1000.0;  // of a thickness or a tool: more is another unit
/// From what drawing programs round to, to what would close slots and small holes.
constexpr double kJoinLeastMm = 0.001, kJoinMostMm = 5.0;

namespace fs = std::filesystem;

std::string extensionOf(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c; });
  return extension;
}

bool isYaml(const fs::path& path) {
  return extensionOf(path) == ".yaml" || extensionOf(path) == ".yml";
}

Eigen::Vector3d readTriple(const YAML::Node& node, const std::string& where,
                           const std::string& key) {
  const std::string expected = "three finite numbers: [0.0, 0.0, 0.0]";
  const auto values = valueAs<std::vector<double>>(node, where, key, expected);
  const bool finite =
      std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
  if (values.size() != 3 || !finite) throwBadValue(where, key, node, expected);
  return {values[0], values[1], values[2]};
}

FaceFilter readFace(const YAML::Node& node, const std::string& where) {
  const std::string expected = "any, front or back";
  const auto word = valueAs<std::string>(node, where, "face", expected);
  if (word == "any") return FaceFilter::kAny;
  if (word == "front") return FaceFilter::kFront;
  if (word == "back") return FaceFilter::kBack;
  throwBadValue(where, "face", node, expected);
}

PickPose readPickPose(const YAML::Node& node, const std::string& where, WrongPicks wrong_picks) {
  if (!node.IsMap())
    throw std::runtime_error(where + ": is " + inOneLine(node) + ", must be a map");
  refuseRepeatedKeys(node, where);
  refuseUnknownKeys(node, where, {"name", "position_mm", "rpy_deg", "face", "symmetric"});
  PickPose pick;
  pick.name = valueAs<std::string>(node["name"], where, "name", "a word");
  if (!isPickName(pick.name)) throwBadValue(where, "name", node["name"], kPickNameExpected);
  if (node["face"]) pick.face = readFace(node["face"], where);
  if (node["symmetric"])
    pick.symmetric = valueAs<bool>(node["symmetric"], where, "symmetric", "true or false");
  pick.T_part_pick.translation() = 1e-3 * readTriple(node["position_mm"], where, "position_mm");
  Eigen::Vector3d rpy = Eigen::Vector3d::Zero();
  if (node["rpy_deg"]) rpy = readTriple(node["rpy_deg"], where, "rpy_deg") * (EIGEN_PI / 180.0);
  // Fixed axes, as everywhere in ROS: first about x, then y, then z of the part.
  pick.T_part_pick.linear() = (Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
                               Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
                               Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()))
                                  .toRotationMatrix();
  const std::string wrong = wrongDirection(pick);
  if (!wrong.empty() && wrong_picks == WrongPicks::kRefused)
    throw std::runtime_error(where + " (" + pick.name + "): " + wrong);
  return pick;
}

std::vector<PickPose> readPickPoses(const YAML::Node& list, const std::string& path,
                                    WrongPicks wrong_picks) {
  if (!list.IsSequence() || list.size() > kPosesMost) {
    throwBadValue(path, "pick_poses", list,
                  "a list of at most " + std::to_string(kPosesMost) + " poses");
  }
  std::vector<PickPose> picks;
  std::set<std::string> names;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string where = path + ": pick_poses[" + std::to_string(i) + "]";
    picks.push_back(readPickPose(list[i], where, wrong_picks));
    if (!names.insert(picks.back().name).second) {
      throw std::runtime_error(where + ": name \"" + picks.back().name + "\" stands there twice");
    }
  }
  return picks;
}

/// @return  metres; nothing where the key is not there
std::optional<double> readMillimetres(const YAML::Node& root, const std::string& key,
                                      const std::string& zero, const std::string& path) {
  if (!root[key]) return std::nullopt;
  const std::string expected = "between 0 " + zero + " and 1000";
  const double value = valueAs<double>(root[key], path, key, expected);
  if (!(value >= 0.0 && value <= kMillimetresMost)) throwBadValue(path, key, root[key], expected);
  return 1e-3 * value;
}

/// 0 where it is not given.
int readNumber(const YAML::Node& root, const std::string& key, const std::string& path) {
  constexpr int kMost = 1000000;  // controllers count less far
  if (!root[key]) return 0;
  const std::string expected = "a whole number between 0 (not said) and 1000000";
  const int value = valueAs<int>(root[key], path, key, expected);
  if (value < 0 || value > kMost) throwBadValue(path, key, root[key], expected);
  return value;
}

DrawingParams readDrawingParams(const YAML::Node& root, const std::string& path) {
  DrawingParams params;
  const auto read = [&](const char* key, std::vector<std::string>* patterns) {
    if (!root[key]) return;
    const std::string expected = "a list of at most " + std::to_string(kLayersMost) + " layers";
    *patterns = valueAs<std::vector<std::string>>(root[key], path, key, expected);
    if (patterns->size() > kLayersMost) throwBadValue(path, key, root[key], expected);
  };
  // Who names the layers to keep means these, whatever the default list says.
  if (root["keep_layers"]) params.skip_layers.clear();
  read("keep_layers", &params.keep_layers);
  read("skip_layers", &params.skip_layers);
  read("print_layers", &params.print_layers);
  if (root["units"]) {
    const std::string expected = "mm, cm, m or inch";
    params.units = valueAs<std::string>(root["units"], path, "units", expected);
    if (params.units != "mm" && params.units != "cm" && params.units != "m" &&
        params.units != "inch") {
      throwBadValue(path, "units", root["units"], expected);
    }
  }
  if (root["join_tolerance_mm"]) {
    const std::string expected = "between 0.001 and 5";
    const double value =
        valueAs<double>(root["join_tolerance_mm"], path, "join_tolerance_mm", expected);
    if (!(value >= kJoinLeastMm && value <= kJoinMostMm))
      throwBadValue(path, "join_tolerance_mm", root["join_tolerance_mm"], expected);
    params.join_tolerance_mm = value;
  }
  return params;
}

/// A path may look as if it stayed in the folder and lead elsewhere through a link; what lies there
/// is none of a part's business, not even in a message.
void refuseOutside(const fs::path& path, const fs::path& folder, const std::string& what) {
  std::error_code error;
  const fs::path here = folder.empty() ? fs::path(".") : folder;
  const fs::path root = fs::weakly_canonical(fs::absolute(here), error);
  const fs::path target = error ? fs::path() : fs::weakly_canonical(fs::absolute(path), error);
  const bool inside =
      !error &&
      std::mismatch(root.begin(), root.end(), target.begin(), target.end()).first == root.end();
  if (inside) return;
  throw std::runtime_error(what + " leads out of the folder " + here.string() +
                           "; put the file itself into that folder");
}

void refuseMissing(const fs::path& path, const std::string& what, const std::string& remedy) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found)
    throw std::runtime_error(what + " does not exist; " + remedy);
  if (error)
    throw std::runtime_error(what + " cannot be read (" + error.message() + "); " + remedy);
  if (!fs::is_regular_file(status)) {
    throw std::runtime_error(what + " is no regular file but a folder, a pipe or a device; " +
                             remedy);
  }
}

const std::vector<std::string> kKeys = {
    "drawing",     "thickness_mm", "units",       "join_tolerance_mm", "keep_layers",
    "skip_layers", "print_layers", "pick_poses",  "tool_radius_mm",    "tool_height_mm",
    "approach_mm", "retreat_mm",   "part_number", "tool_number"};

/// Other files of this package that may lie in the same folder, by a key that each must have.
const std::vector<std::pair<std::string, std::string>> kOtherFiles = {
    {"detections", "a result of locate_image"},
    {"camera_matrix", "a camera's calibration"},
    {"K", "a printed CameraInfo message"},
    {"child_frame", "a hand-eye transform"},
    {"verdict", "the report of a calibration"}};

/// @return  the same node
const YAML::Node& checkedPartYaml(const YAML::Node& root, const std::string& path) {
  const std::string remedy = "; a part file has the key drawing, or leave it out of the parts";
  if (!root.IsMap()) {
    const char* what = root.IsSequence() ? "it is a list" : "it has no \"key: value\" lines";
    throw NoPartFile(path + ": is no part file, " + what + remedy);
  }
  const bool any = std::any_of(kKeys.begin(), kKeys.end(),
                               [&](const std::string& key) { return root[key].IsDefined(); });
  for (const auto& [key, what] : kOtherFiles) {
    if (!any && root[key]) throw NoPartFile(path + ": is no part file but " + what + remedy);
  }
  if (!any)
    throw NoPartFile(path + ": is no part file, it has none of a part file's keys" + remedy);
  refuseRepeatedKeys(root, path);
  refuseUnknownKeys(root, path, kKeys);
  return root;
}

PartFile loadYamlPart(const fs::path& path, WrongPicks wrong_picks) {
  const std::string name = path.string();
  const YAML::Node root = checkedPartYaml(loadYaml(name), name);
  PartFile part;
  part.yaml_path = name;
  const auto drawing =
      valueAs<std::string>(root["drawing"], name, "drawing", "a DXF file beside this one");
  part.thickness = readMillimetres(root, "thickness_mm", "(unknown)", name).value_or(0.0);
  part.tool.radius = readMillimetres(root, "tool_radius_mm", "(not looked at)", name);
  part.tool.height = readMillimetres(root, "tool_height_mm", "(no end)", name);
  part.robot.approach = readMillimetres(root, "approach_mm", "(none)", name);
  part.robot.retreat = readMillimetres(root, "retreat_mm", "(none)", name);
  part.robot.part_number = readNumber(root, "part_number", name);
  part.robot.tool_number = readNumber(root, "tool_number", name);
  if (root["pick_poses"]) part.pick_poses = readPickPoses(root["pick_poses"], name, wrong_picks);
  const DrawingParams params = readDrawingParams(root, name);
  const fs::path folder = path.parent_path(), drawing_path = folder / drawing;
  refuseOutside(drawing_path, folder, name + ": drawing " + inOneLine(root["drawing"]));
  refuseMissing(drawing_path, name + ": drawing " + drawing_path.string(),
                "the path is relative to this file");
  part.drawing = loadDrawing(drawing_path.string(), params);
  part.warnings = pickWarnings(part.pick_poses, part.tool, part.drawing, part.thickness);
  return part;
}

/// Names in a folder that begin with a stem and a dot. The library's iterator makes a path of every
/// name: among a thousand files that takes longer than to read the drawing.
std::vector<std::string> namesBeside(const fs::path& folder, const std::string& stem) {
  auto close = [](DIR* entries) { closedir(entries); };
  const std::unique_ptr<DIR, decltype(close)> entries(opendir(folder.c_str()), close);
  std::vector<std::string> names;
  const std::string begin = stem + ".";
  while (entries) {
    errno = 0;
    const dirent* const entry = readdir(entries.get());
    if (entry == nullptr) break;
    if (std::strncmp(entry->d_name, begin.c_str(), begin.size()) == 0)
      names.emplace_back(entry->d_name);
  }
  if (!entries || errno != 0) {
    throw std::runtime_error(folder.string() + ": cannot be read (" +
                             std::generic_category().message(errno) +
                             "), and a part file may lie there");
  }
  return names;
}

/// Part files of that stem in that folder: whether .yaml or .yml, in capitals or not.
std::vector<fs::path> partFilesBeside(const fs::path& given) {
  std::vector<fs::path> found;
  const fs::path folder = given.has_parent_path() ? given.parent_path() : fs::path(".");
  for (const std::string& text : namesBeside(folder, given.stem().string())) {
    const fs::path name(text);
    if (isYaml(name) && name.stem() == given.stem()) found.push_back(given.parent_path() / name);
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace

PartFile loadPartFile(const std::string& path, WrongPicks wrong_picks) {
  const fs::path given(path);
  const std::string remedy = "give a part's .yaml or .dxf";
  if (path.empty()) throw std::runtime_error("the path of a part is empty; " + remedy);
  const fs::path folder = given.parent_path();
  refuseOutside(given, folder, path + ":");
  refuseMissing(given, path + ":", remedy);
  if (!isYaml(given) && extensionOf(given) != ".dxf")
    throw std::runtime_error(path + ": is no part; " + remedy);
  const std::vector<fs::path> beside = partFilesBeside(given);
  if (beside.size() > 1) {
    throw std::runtime_error(path + ": part \"" + given.stem().string() +
                             "\" has two part files, " + beside[0].string() + " and " +
                             beside[1].string() + "; keep one");
  }
  PartFile part;
  if (isYaml(given)) {
    part = loadYamlPart(given, wrong_picks);
  } else if (!beside.empty()) {
    refuseOutside(beside[0], folder, beside[0].string() + ":");
    refuseMissing(beside[0], beside[0].string() + ":", remedy);
    part = loadYamlPart(beside[0], wrong_picks);
  } else {
    part.drawing = loadDrawing(path);
  }
  part.name = given.stem().string();
  return part;
}

std::vector<PickPose> pickPosesIn(const std::string& text, const std::string& path,
                                  WrongPicks wrong_picks) {
  const YAML::Node root = checkedPartYaml(parseYaml(text, path), path);
  if (!root["pick_poses"]) return {};
  return readPickPoses(root["pick_poses"], path, wrong_picks);
}

std::optional<std::string> drawingNamedBy(const std::string& part_file) {
  try {
    const YAML::Node root = checkedPartYaml(loadYaml(part_file), part_file);
    std::string drawing;
    if (!root["drawing"] || !convert(root["drawing"], &drawing)) return std::nullopt;
    return (fs::path(part_file).parent_path() / drawing).lexically_normal().string();
  } catch (const std::runtime_error&) {
    return std::nullopt;  // loading it says why
  }
}

}  // namespace planar_bin_picking
