// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Names of layers, blocks and line types: from the bytes of a DXF file to UTF-8, and how they are
/// compared.

#include <string>
#include <string_view>
#include <vector>

namespace planar_bin_picking {

/// Turns a file's names into UTF-8.
class DxfNames {
 public:
  /// @param code_page  the header's DWGCODEPAGE, such as ANSI_1252; may be empty
  /// @param version    the header's ACADVER; from AC1021 on files are UTF-8
  DxfNames(std::string_view code_page, std::string_view version);
  DxfNames() : DxfNames({}, {}) {}

  /// UTF-8, with `\U+XXXX` and `\M+NXXXX` resolved. Bytes that mean nothing become '?'.
  std::string decode(std::string_view bytes) const;

 private:
  std::string encoding_;  ///< as iconv calls it
};

/// Both cases become one, in all alphabets that have two: names in DXF do not tell them apart.
std::string upperCase(std::string_view utf8);

/// `*` in the pattern stands for anything, all else for itself; without case.
bool matchesPattern(std::string_view text, std::string_view pattern);

/// Also where the name was taken over from another drawing and carries its name in front:
/// `SHEET|DIM` matches DIM*, and so does `SHEET$0$DIM`, which binding makes of it.
bool matchesAny(std::string_view name, const std::vector<std::string>& patterns);

}  // namespace planar_bin_picking
