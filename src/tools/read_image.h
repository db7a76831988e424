// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Picture files, read so that one that is damaged is refused.

#include "base/regular_file.h"

#include <unistd.h>

#include <opencv2/imgcodecs.hpp>

#include <cstdio>
#include <stdexcept>
#include <string>

namespace planar_bin_picking {

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

/// @param flags  of cv::imread; but for IMREAD_UNCHANGED, the picture is turned as its EXIF data
/// say
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

}  // namespace planar_bin_picking
