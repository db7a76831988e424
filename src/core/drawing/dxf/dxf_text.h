// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The text of a DXF file as a sequence of groups: a code and a value, one line each.
///
/// Line ends may be those of any system, also mixed. What cannot be a whole DXF file is refused
/// with its line.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace planar_bin_picking {

/// One code and its value: the atom of a DXF file.
struct DxfGroup {
  int code = 0;
  std::string_view value;  ///< without blanks around it
  std::size_t line = 0;    ///< of the value, from 1
};

/// A group with code 0 or 9 and all that belongs to it.
using DxfRecord = std::vector<DxfGroup>;

/// @throws std::runtime_error  naming the line, not the file
[[noreturn]] void refuseLine(std::size_t line, const std::string& what);

/// Walks through the records of a file.
class DxfText {
 public:
  /// @param content  must outlive this object and the records that it gives
  /// @throws std::runtime_error  empty, binary, no DXF at all
  explicit DxfText(std::string_view content);

  /// The next record; the last one is that of EOF.
  /// @return  false after it
  /// @throws std::runtime_error  truncated, damaged
  bool next(DxfRecord* record);

 private:
  bool nextLine(std::string_view* line);
  void nextGroup(DxfGroup* group);

  std::string_view content_;
  std::size_t position_ = 0, line_ = 0;
  bool any_ = false;  ///< a group has been read
  DxfGroup ahead_;    ///< the head of the next record
};

/// Numbers as DXF files have them: with points, or with decimal commas as some programs write them.
/// @throws std::runtime_error  naming line and `owner`: no number, not finite, or so small that it
/// is
///         none (rubbish of memory that was never written)
double realOf(const DxfGroup& group, std::string_view owner);
int integerOf(const DxfGroup& group, std::string_view owner);

/// The first group with this code behind the record's head, if there is one.
const DxfGroup* findGroup(const DxfRecord& record, int code);
double realOf(const DxfRecord& record, int code, double otherwise);
int integerOf(const DxfRecord& record, int code, int otherwise);
std::string_view textOf(const DxfRecord& record, int code, std::string_view otherwise);

}  // namespace planar_bin_picking
