// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What the command line tools have in common: options of the form `--name value`, and one line on
/// stderr with exit status 2 for whatever is wrong with what they were given.

#include "base/regular_file.h"

#include <unistd.h>

#include <opencv2/imgcodecs.hpp>

#include <cmath>
#include <cstdio>
#include <exception>
#include <functional>
#include <locale>
#include <map>
#include <new>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace planar_bin_picking {

inline constexpr int kDone = 0, kBadInput = 2;  ///< exit status

inline bool isHelp(const std::string& argument) { return argument == "--help" || argument == "-h"; }

/// Takes the value of an option; throws std::invalid_argument where it is none.
using TakeValue = std::function<void(const std::string& option, const std::string& value)>;

inline TakeValue text(std::string* target) {
  return [target](const std::string& option, const std::string& value) {
    if (!target->empty()) throw std::invalid_argument(option + " is given twice; keep one");
    *target = value;
  };
}

inline TakeValue metres(double* target) {
  return [target](const std::string& option, const std::string& value) {
    if (*target > 0.0) throw std::invalid_argument(option + " is given twice; keep one");
    std::istringstream in(value);
    in.imbue(std::locale::classic());
    if (!(in >> *target) || !(in >> std::ws).eof() || !std::isfinite(*target) || *target <= 0.0) {
      throw std::invalid_argument(option + " is \"" + value + "\", must be metres greater than 0");
    }
  };
}

/// @return  false where help is asked for: then nothing else counts
inline bool parseOptions(const std::vector<std::string>& arguments,
                         const std::map<std::string, TakeValue>& known) {
  for (const std::string& argument : arguments) {
    if (isHelp(argument)) return false;
  }
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& option = arguments[i];
    const auto take = known.find(option);
    if (take == known.end()) {
      throw std::invalid_argument("unknown option \"" + option + "\"; see --help");
    }
    if (++i == arguments.size() || arguments[i].empty()) {
      throw std::invalid_argument(option + " needs a value; see --help");
    }
    take->second(option, arguments[i]);
  }
  return true;
}

inline void require(bool given, const std::string& option) {
  if (!given) throw std::invalid_argument(option + " is missing; see --help");
}

/// What libraries write to stderr while it lives, so that a complaint stays one line and is heeded.
class CapturedComplaints {
 public:
  CapturedComplaints() : file_(std::tmpfile()), stderr_(dup(STDERR_FILENO)) {
    if (file_ != nullptr) dup2(fileno(file_), STDERR_FILENO);
  }
  ~CapturedComplaints() {
    std::fflush(stderr);
    if (stderr_ >= 0) {
      dup2(stderr_, STDERR_FILENO);
      close(stderr_);
    }
    if (file_ != nullptr) std::fclose(file_);
  }
  CapturedComplaints(const CapturedComplaints&) = delete;
  CapturedComplaints& operator=(const CapturedComplaints&) = delete;

  std::string text() const {
    std::fflush(stderr);
    std::string text(1000, '\0');
    const ssize_t size = file_ == nullptr ? 0 : pread(fileno(file_), &text[0], text.size(), 0);
    text.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
    return text;
  }

 private:
  std::FILE* file_;
  int stderr_;
};

/// A JPEG that ends early comes back grey from there on: parts would be missed without a word.
inline bool isCutJpeg(const std::string& bytes) {
  constexpr std::size_t kTrailerMost = 4096;  // what some cameras add after the end
  if (bytes.compare(0, 3, "\xFF\xD8\xFF") != 0) return false;
  const std::size_t end = bytes.rfind("\xFF\xD9");
  return end == std::string::npos || end + kTrailerMost < bytes.size();
}

/// @param flags  of cv::imread
inline cv::Mat readImage(const std::string& path, int flags) {
  constexpr std::size_t kBytesMost = 1u << 30;  // 16 bit, three channels and 150 million pixels
  const std::string bytes = readRegularFile(path, kBytesMost);
  const cv::Mat buffer(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data()));
  cv::Mat image;
  std::string complaint;
  try {
    const CapturedComplaints captured;
    if (!bytes.empty()) image = cv::imdecode(buffer, flags);
    complaint = captured.text();
  } catch (const cv::Exception& e) {
    complaint = e.err;
  }
  const bool corrupt = complaint.find("orrupt") != std::string::npos;
  if (image.empty() || corrupt || isCutJpeg(bytes)) {
    throw std::runtime_error(path + ": cannot be read as a picture; is it one, and whole?" +
                             (complaint.empty() ? "" : " (" + complaint + ")"));
  }
  return image;
}

/// Says in one line, whatever the message holds, why input is refused.
inline int refuse(const std::string& tool, std::string message) {
  for (char& c : message) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  }
  std::fprintf(stderr, "%s: %s\n", tool.c_str(), message.c_str());
  return kBadInput;
}

/// @param work  returns the exit status
template <class Work>
int runTool(const std::string& tool, Work&& work) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    return refuse(tool, "out of memory; is the input what it is meant to be?");
  } catch (const std::exception& e) {
    return refuse(tool, e.what());
  }
}

}  // namespace planar_bin_picking
