// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/robot/robot_line.h"

#include <algorithm>
#include <iomanip>
#include <locale>
#include <sstream>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

constexpr std::size_t kTextMost = 200;  // characters; controllers have short strings

std::string lower(std::string word) {
  for (char& c : word)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return word;
}

std::vector<std::string> words(const std::string& line) {
  for (const char c : line)
    if ((static_cast<unsigned char>(c) < ' ' && c != '\t') || c == 0x7F)
      throw std::invalid_argument("the line has a control character in it");
  std::istringstream in(line);
  std::vector<std::string> found;
  for (std::string word; in >> word;) found.push_back(word);
  return found;
}

double number(const std::string& word) {
  std::istringstream in(word);
  in.imbue(std::locale::classic());
  double value = 0.0;
  if (!(in >> value) || !in.eof())
    throw std::invalid_argument("\"" + word.substr(0, 40) + "\" is no number");
  return value;
}

/// "flange" and its numbers, which end the line.
void takeFlange(const std::vector<std::string>& all, std::size_t at, PoseConvention convention,
                RobotCommand* command) {
  std::vector<double> numbers;
  for (; at < all.size(); ++at) numbers.push_back(number(all[at]));
  command->T_base_flange = fromNumbers(numbers, convention);
}

RobotCommand parseLocate(const std::vector<std::string>& all, PoseConvention convention) {
  RobotCommand command;
  command.kind = RobotCommand::Kind::kLocate;
  for (std::size_t i = 1; i < all.size(); ++i) {
    const std::string word = lower(all[i]);
    if (word == "flange") {
      takeFlange(all, i + 1, convention, &command);
      break;
    }
    if (word == "front") {
      command.face = FaceFilter::kFront;
    } else if (word == "back") {
      command.face = FaceFilter::kBack;
    } else if (word != "*") {
      command.parts.push_back(all[i]);
    }
  }
  return command;
}

RobotCommand parseReport(const std::vector<std::string>& all) {
  RobotCommand command;
  command.kind = RobotCommand::Kind::kReport;
  const std::string word = all.size() == 2 ? lower(all[1]) : "";
  if (word != "ok" && word != "failed")
    throw std::invalid_argument("report takes one word: ok or failed");
  command.success = word == "ok";
  return command;
}

RobotCommand parseCalibrate(const std::vector<std::string>& all) {
  RobotCommand command;
  command.kind = RobotCommand::Kind::kCalibrate;
  command.step = all.size() == 2 ? lower(all[1]) : "";
  std::string known;
  for (const char* const step : kCalibrateSteps) {
    if (command.step == step) return command;
    known += (known.empty() ? "" : ", ") + std::string(step);
  }
  throw std::invalid_argument("calibrate takes one word of " + known);
}

/// Sixteen digits would overflow some controllers' lines.
std::string text(const double value) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out << std::fixed << std::setprecision(6) << (value == 0.0 ? 0.0 : value);
  return out.str();
}

/// A name of ASCII without spaces: fields are told apart by these.
std::string asWord(std::string name) {
  for (char& c : name)
    if (c <= ' ' || c > '~') c = '?';
  return name;
}

std::string join(const std::vector<std::string>& numbers, const char* separator) {
  std::string line;
  for (const std::string& number : numbers) line += (line.empty() ? "" : separator) + number;
  return line;
}

}  // namespace

RobotCommand parseRobotLine(const std::string& line, const PoseConvention convention) {
  const auto all = words(line);
  const std::string verb = all.empty() ? "" : lower(all.front());
  RobotCommand command;
  if (verb == "locate") return parseLocate(all, convention);
  if (verb == "report") return parseReport(all);
  if (verb == "calibrate") return parseCalibrate(all);
  if (verb == "next" || verb == "hello") {
    if (all.size() > 1) throw std::invalid_argument(verb + " takes no further word");
    command.kind = verb == "next" ? RobotCommand::Kind::kNext : RobotCommand::Kind::kHello;
    return command;
  }
  throw std::invalid_argument("\"" + verb.substr(0, 40) +
                              "\" is not known; known are hello, locate, next, report, calibrate");
}

std::string poseLine(const RobotPose& pose, const PoseConvention convention) {
  const auto code = static_cast<int>(RobotCode::kPose);
  const int face = pose.face == Face::kFront ? 1 : 2;
  std::vector<std::string> numbers{std::to_string(code), std::to_string(pose.left),
                                   std::to_string(face)};
  if (pose.numbers)
    for (const unsigned n : {pose.numbers->first, pose.numbers->second})
      numbers.push_back(std::to_string(n));
  const auto add = [&](const Eigen::Isometry3d& T) {
    for (const double n : toNumbers(T, convention)) numbers.push_back(text(n));
  };
  add(pose.T_base_target);
  if (pose.T_base_approach) add(*pose.T_base_approach);
  if (pose.T_base_retreat) add(*pose.T_base_retreat);
  if (convention == PoseConvention::kUr) return "(" + join(numbers, ",") + ")\n";
  return join(numbers, " ") + " " + asWord(pose.part) + " " + asWord(pose.pick) + "\n";
}

std::string textLine(const RobotCode code, const std::string& text, const PoseConvention convention,
                     const std::size_t count) {
  const std::string number = std::to_string(static_cast<int>(code));
  if (convention == PoseConvention::kUr) {
    std::vector<std::string> numbers(std::max<std::size_t>(1, count), "0");
    numbers.front() = number;
    return "(" + join(numbers, ",") + ")\n";
  }
  std::string line = text.substr(0, kTextMost);
  for (char& c : line)
    if (c < ' ' || c > '~') c = '?';
  return number + " " + line + "\n";
}

}  // namespace planar_bin_picking
