// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "snapshot/grey_file.h"

#include <cctype>
#include <cstdint>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

constexpr int kMostPixels = 1 << 16;  // per side
constexpr int kFull8 = 255, kFull16 = 65535;

/// The next number of the header; one white space follows it.
int number(const std::string& bytes, std::size_t* at, const std::string& path) {
  while (*at < bytes.size() && std::isspace(static_cast<unsigned char>(bytes[*at]))) ++*at;
  int value = 0;
  const std::size_t begin = *at;
  for (; *at < bytes.size() && bytes[*at] >= '0' && bytes[*at] <= '9'; ++*at) {
    value = 10 * value + (bytes[*at] - '0');
    if (value > kMostPixels) break;
  }
  if (*at == begin || value > kMostPixels)
    throw std::runtime_error(path + ": its header is no binary graymap's; it is damaged");
  return value;
}

}  // namespace

std::string toPgm(const cv::Mat& grey) {
  const bool is_wide = grey.depth() == CV_16U;
  std::string bytes = "P5\n" + std::to_string(grey.cols) + " " + std::to_string(grey.rows) + "\n" +
                      std::to_string(is_wide ? kFull16 : kFull8) + "\n";
  bytes.reserve(bytes.size() + grey.total() * grey.elemSize());
  for (int row = 0; row < grey.rows; ++row) {
    if (!is_wide) {
      bytes.append(reinterpret_cast<const char*>(grey.ptr(row)),
                   static_cast<std::size_t>(grey.cols));
      continue;
    }
    const auto* values = grey.ptr<std::uint16_t>(row);
    for (int column = 0; column < grey.cols; ++column) {  // the format's order: high byte first
      bytes.push_back(static_cast<char>(values[column] >> 8));
      bytes.push_back(static_cast<char>(values[column] & 0xFF));
    }
  }
  return bytes;
}

cv::Mat fromPgm(const std::string& bytes, const std::string& path) {
  if (bytes.compare(0, 2, "P5") != 0)
    throw std::runtime_error(path + ": is no binary graymap (P5); take the file as it was written");
  std::size_t at = 2;
  const int columns = number(bytes, &at, path), rows = number(bytes, &at, path);
  const int full = number(bytes, &at, path);
  if (full != kFull8 && full != kFull16)
    throw std::runtime_error(path + ": has " + std::to_string(full) + " levels; 255 or 65535 are");
  ++at;  // the white space after the header
  cv::Mat grey(rows, columns, full == kFull8 ? CV_8U : CV_16U);
  const std::size_t size = grey.total() * grey.elemSize();
  if (size == 0 || bytes.size() < at + size)
    throw std::runtime_error(path + ": ends early; copy it again");
  const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data()) + at;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      if (full == kFull8) {
        grey.at<std::uint8_t>(row, column) = *data++;
      } else {
        grey.at<std::uint16_t>(row, column) = static_cast<std::uint16_t>(data[0] << 8 | data[1]);
        data += 2;
      }
    }
  }
  return grey;
}

}  // namespace planar_bin_picking
