// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "teach/pick_text.h"

#include "base/yaml_file.h"
#include "base/yaml_text.h"
#include "planar_bin_picking/part/part_file.h"
#include "teach/text_edit.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

constexpr char kKey[] = "pick_poses";
constexpr int kDecimals = 3;  // of millimetres and degrees: finer than any robot
/// Metres and radians: what rounding to these may do to three numbers, and a little more.
constexpr double kRoundedMetres = 2e-6, kRoundedRadians = 5e-5;
constexpr double kDegree = EIGEN_PI / 180.0;
constexpr double kNearlyHalf = 180.0 + 0.0005;  // degrees; by rounding a half turn

[[noreturn]] void refuse(const std::string& what) {
  throw std::runtime_error("the file's pick_poses cannot be changed safely: " + what);
}

/// "30", "30.5", "-0.125".
std::string shortNumber(double value) {
  std::string text = yamlNumber(value, kDecimals);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

std::string triple(const Eigen::Vector3d& v) {
  return "[" + shortNumber(v.x()) + ", " + shortNumber(v.y()) + ", " + shortNumber(v.z()) + "]";
}

/// About the fixed x, y and z axes, in this order, degrees. A pose whose z points into the part is
/// never turned by 90 degrees about y, where they would not be unique.
Eigen::Vector3d rpyDeg(const Eigen::Matrix3d& R) {
  Eigen::Vector3d rpy(std::atan2(R(2, 1), R(2, 2)),
                      std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0))),
                      std::atan2(R(1, 0), R(0, 0)));
  rpy /= kDegree;
  for (double& angle : rpy)
    if (angle < kNearlyHalf - 360.0) angle += 360.0;  // 180, not -180
  return rpy;
}

std::string positionText(const PickPose& pose) {
  return triple(1e3 * pose.T_part_pick.translation());
}

std::string rotationText(const PickPose& pose) { return triple(rpyDeg(pose.T_part_pick.linear())); }

std::string faceText(const PickPose& pose) {
  if (pose.face == FaceFilter::kAny) return "any";
  return pose.face == FaceFilter::kFront ? "front" : "back";
}

std::string entryText(const PickPose& pose) {
  return "- {name: " + yamlText(pose.name) + ", face: " + faceText(pose) +
         ", position_mm: " + positionText(pose) + ", rpy_deg: " + rotationText(pose) +
         (pose.symmetric ? "" : ", symmetric: false") + "}";
}

double turnBetween(const PickPose& a, const PickPose& b) {
  return Eigen::Quaterniond(a.T_part_pick.linear())
      .angularDistance(Eigen::Quaterniond(b.T_part_pick.linear()));
}

bool isSamePosition(const PickPose& a, const PickPose& b) {
  return (a.T_part_pick.translation() - b.T_part_pick.translation()).norm() < kRoundedMetres;
}

/// Where a node begins, in bytes.
std::size_t placeOf(const YAML::Node& node) { return static_cast<std::size_t>(node.Mark().pos); }

/// The text of a part file while its poses are changed.
class Editor {
 public:
  explicit Editor(const std::string& text)
      : edit_(text),
        root_(YAML::Load(text)),
        before_(pickPosesIn(text, "the part file", WrongPicks::kWarned)) {
    if (!root_.IsMap() || root_.Style() == YAML::EmitterStyle::Flow)
      refuse("it stands in braces; write it as lines \"key: value\"");
    for (const auto& entry : root_) {
      if (entry.first.Scalar() == kKey) key_ = placeOf(entry.first);
    }
  }

  std::string with(const std::vector<PickPose>& poses) {
    if (before_.empty() && poses.empty()) return edit_.text();
    if (!root_[kKey]) {
      append(poses);
    } else if (before_.empty() || root_[kKey].Style() == YAML::EmitterStyle::Flow) {
      changeFlow(poses);
    } else {
      changeBlock(poses);
    }
    return edit_.result();
  }

  /// The poses that there are, in the order of these.
  std::string ordered(const std::vector<PickPose>& poses) {
    const auto isSameName = [](const PickPose& a, const PickPose& b) { return a.name == b.name; };
    if (before_.size() != poses.size() ||
        std::equal(before_.begin(), before_.end(), poses.begin(), isSameName))
      return edit_.text();
    if (root_[kKey].Style() == YAML::EmitterStyle::Flow) {
      rewriteFlow(poses);
      return edit_.result();
    }
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const PickPose* const before = find(before_, poses[i].name);
      if (before == nullptr) return edit_.text();
      putEntry(i, static_cast<std::size_t>(before - before_.data()));
    }
    return edit_.result();
  }

 private:
  /// What stands at entry `from` in the place of entry `to`.
  void putEntry(std::size_t to, std::size_t from) {
    if (to == from) return;
    const std::string& text = edit_.text();
    std::string entry = text.substr(entryBegin(from), entryEnd(from) - entryBegin(from));
    while (!entry.empty() && (entry.back() == '\n' || entry.back() == '\r')) entry.pop_back();
    const bool is_open = text[entryEnd(to) - 1] != '\n';  // the file's last line
    edit_.replace(entryBegin(to), entryEnd(to), entry + (is_open ? "" : edit_.lineEnd()));
  }

  const PickPose* find(const std::vector<PickPose>& poses, const std::string& name) const {
    const auto found = std::find_if(poses.begin(), poses.end(),
                                    [&](const PickPose& pose) { return pose.name == name; });
    return found == poses.end() ? nullptr : &*found;
  }

  std::vector<PickPose> newOnes(const std::vector<PickPose>& poses) const {
    std::vector<PickPose> added;
    for (const PickPose& pose : poses)
      if (find(before_, pose.name) == nullptr) added.push_back(pose);
    return added;
  }

  std::string lines(const std::vector<PickPose>& poses, const std::string& indent) const {
    std::string lines;
    for (const PickPose& pose : poses) lines += indent + entryText(pose) + edit_.lineEnd();
    return lines;
  }

  /// At the end of a file that has no pick poses yet.
  void append(const std::vector<PickPose>& poses) {
    const std::string& text = edit_.text();
    const bool is_open = !text.empty() && text.back() != '\n';
    const std::string begin = std::string(is_open ? edit_.lineEnd() : "") + kKey + ":";
    edit_.insert(text.size(), begin + edit_.lineEnd() + lines(poses, "  "));
  }

  std::size_t afterColon() const {
    const std::size_t colon = edit_.text().find(':', key_);
    if (colon == std::string::npos) refuse("no colon follows its key");
    return colon + 1;
  }

  /// [{...}, {...}]
  void changeFlow(const std::vector<PickPose>& poses) {
    const bool has_all = newOnes(poses).empty() && poses.size() == before_.size();
    if (has_all) {
      for (std::size_t i = 0; i < before_.size(); ++i) changeEntry(i, poses);
      return;
    }
    rewriteFlow(poses);
  }

  /// As lines in place of the brackets.
  void rewriteFlow(const std::vector<PickPose>& poses) {
    const std::size_t begin = edit_.text().find('[', afterColon());
    bool has_comment = false;
    const std::size_t end =
        begin == std::string::npos ? begin : edit_.afterBracket(begin, &has_comment);
    const bool is_next = begin != std::string::npos &&
                         edit_.text().find_first_not_of(" \t\r\n", afterColon()) == begin;
    if (end == std::string::npos || !is_next || has_comment)
      refuse("write them as a list of lines \"- {name: ...}\" below the key, not in brackets");
    std::string text = edit_.lineEnd() + lines(poses, "  ");
    text.erase(text.size() - edit_.lineEnd().size());  // the last line's end stands there already
    edit_.replace(afterColon(), end, poses.empty() ? " []" : text);
  }

  void changeBlock(const std::vector<PickPose>& poses) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < before_.size(); ++i) {
      if (find(poses, before_[i].name) == nullptr) {
        edit_.replace(entryBegin(i), entryEnd(i), "");
      } else {
        changeEntry(i, poses);
        ++kept;
      }
    }
    const std::vector<PickPose> added = newOnes(poses);
    if (kept + added.size() == 0) edit_.insert(afterColon(), " []");
    if (added.empty()) return;
    const std::size_t begin = entryBegin(0), end = entryEnd(before_.size() - 1);
    const std::string indent = edit_.text().substr(begin, edit_.text().find('-', begin) - begin);
    const bool is_open = edit_.text()[end - 1] != '\n';
    edit_.insert(end, (is_open ? edit_.lineEnd() : "") + lines(added, indent));
  }

  /// The line of an entry's dash.
  std::size_t entryBegin(std::size_t i) const {
    const std::string& text = edit_.text();
    std::size_t at = placeOf(root_[kKey][i]);
    while (at > 0 && std::string(" \r\n").find(text[at - 1]) != std::string::npos) --at;
    const std::size_t line = at == 0 ? 0 : edit_.lineBegin(at - 1);
    if (at == 0 || text[at - 1] != '-' || text.find_first_not_of(' ', line) != at - 1)
      refuse("write each pose as a line of its own, \"- {name: ...}\"");
    return line;
  }

  /// Behind the line of an entry's last word.
  std::size_t entryEnd(std::size_t i) const {
    std::size_t limit = edit_.text().size();
    if (i + 1 < before_.size()) {
      limit = entryBegin(i + 1);
    } else {
      for (const auto& entry : root_) {
        const std::size_t key = placeOf(entry.first);
        if (key > key_) limit = std::min(limit, edit_.lineBegin(key));
      }
    }
    std::size_t end = edit_.lineAfter(placeOf(root_[kKey][i]));
    for (std::size_t line = end; line < limit; line = edit_.lineAfter(line)) {
      const std::string mark = edit_.text().substr(line, 3);
      if (mark == "---" || mark == "...") break;  // the document's end
      if (!edit_.isBlankOrComment(line)) end = edit_.lineAfter(line);
    }
    return end;
  }

  /// Writes the values that are others now.
  void changeEntry(std::size_t i, const std::vector<PickPose>& poses) {
    const PickPose& before = before_[i];
    const PickPose* after = find(poses, before.name);
    if (after == nullptr || isSamePick(before, *after)) return;
    const YAML::Node entry = root_[kKey][i];
    if (!isSamePosition(before, *after)) changeTriple(entry["position_mm"], positionText(*after));
    if (turnBetween(before, *after) > kRoundedRadians) {
      if (entry["rpy_deg"]) {
        changeTriple(entry["rpy_deg"], rotationText(*after));
      } else {
        addKey(entry, "rpy_deg: " + rotationText(*after));
      }
    }
    if (before.face != after->face) changeFace(entry, before, *after);
  }

  void changeFace(const YAML::Node& entry, const PickPose& before, const PickPose& after) {
    if (!entry["face"]) return addKey(entry, "face: " + faceText(after));
    const std::size_t at = placeOf(entry["face"]);
    const std::string face = faceText(before);
    const bool quoted = edit_.text()[at] == '"' || edit_.text()[at] == '\'';
    if (edit_.text().compare(at + quoted, face.size(), face) != 0)
      refuse("write each pose's face as front or back");
    edit_.replace(at + quoted, at + quoted + face.size(), faceText(after));
  }

  std::size_t tripleEnd(const YAML::Node& node) const {
    bool has_comment = false;
    const std::size_t at = placeOf(node);
    const std::size_t end =
        edit_.text()[at] == '[' ? edit_.afterBracket(at, &has_comment) : std::string::npos;
    if (end == std::string::npos || has_comment)
      refuse("write each position_mm and rpy_deg as three numbers in brackets, [0, 0, 0]");
    return end;
  }

  void changeTriple(const YAML::Node& node, const std::string& text) {
    const std::size_t end = tripleEnd(node);
    edit_.replace(placeOf(node), end, text);
  }

  /// After the position, which each has.
  void addKey(const YAML::Node& entry, const std::string& text) {
    const std::size_t end = tripleEnd(entry["position_mm"]);
    if (entry.Style() == YAML::EmitterStyle::Flow) {
      edit_.insert(end, ", " + text);
      return;
    }
    int column = 0;
    for (const auto& pair : entry)
      if (pair.first.Scalar() == "position_mm") column = pair.first.Mark().column;
    const std::size_t line = edit_.text().find_first_of("\r\n", end);
    edit_.insert(line == std::string::npos ? edit_.text().size() : line,
                 edit_.lineEnd() + std::string(static_cast<std::size_t>(column), ' ') + text);
  }

  TextEdit edit_;
  const YAML::Node root_;
  std::vector<PickPose> before_;
  std::size_t key_ = 0;
};

std::map<std::string, std::string> otherValues(const std::string& text) {
  std::map<std::string, std::string> values;
  for (const auto& entry : YAML::Load(text)) {
    if (entry.first.Scalar() != kKey) values[entry.first.Scalar()] = YAML::Dump(entry.second);
  }
  return values;
}

bool isReadable(const std::string& text) {
  try {
    pickPosesIn(text, "the part file", WrongPicks::kWarned);
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

/// What a change has made of a file is read as whoever uses it reads it.
void check(const std::string& before, const std::string& after,
           const std::vector<PickPose>& poses) {
  std::vector<PickPose> read;
  try {
    read = pickPosesIn(after, "the part file");
    if (otherValues(before) != otherValues(after))
      throw std::runtime_error("other values of the file would change with them");
  } catch (const std::exception& error) {
    refuse(std::string(error.what()) +
           "; write each pose as a line \"- {name: ...}\", without anchors (&) and aliases (*)");
  }
  if (std::equal(read.begin(), read.end(), poses.begin(), poses.end(), isSamePick)) return;
  refuse(
      "they would not be read as they are; write each as a line \"- {name: ...}\", without anchors "
      "(&) and aliases (*)");
}

}  // namespace

bool isSamePick(const PickPose& a, const PickPose& b) {
  return a.name == b.name && a.face == b.face && a.symmetric == b.symmetric &&
         isSamePosition(a, b) && turnBetween(a, b) < kRoundedRadians;
}

std::string withPickPoses(const std::string& text, const std::vector<PickPose>& poses,
                          const FormerNames& names) {
  // The mark that some editors put first is no part of the positions that the parser gives.
  const std::string mark = text.compare(0, 3, "\xEF\xBB\xBF") == 0 ? "\xEF\xBB\xBF" : "";
  const std::string bare = text.substr(mark.size());
  std::string after = Editor(withNames(bare, names)).with(poses);
  // Else it is not what it should be: the check says so.
  if (isReadable(after)) after = Editor(after).ordered(poses);
  check(bare, after, poses);
  return mark + after;
}

}  // namespace planar_bin_picking
