// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Places in a text, and changes at them that are made all at once.

#include <cstddef>
#include <string>
#include <vector>

namespace planar_bin_picking {

/// Collects changes, whose places are those in the text as it was.
class TextEdit {
 public:
  explicit TextEdit(std::string text);

  const std::string& text() const { return text_; }
  /// "\n", or "\r\n" where the text's first line ends so.
  const std::string& lineEnd() const { return line_end_; }

  std::size_t lineBegin(std::size_t at) const;  ///< of the line that `at` lies in
  std::size_t lineAfter(std::size_t at) const;  ///< begin of the next line, or the text's end
  /// Whether nothing but spaces, or a comment, stands in the line that begins there.
  bool isBlankOrComment(std::size_t line_begin) const;
  /// Behind the bracket that closes the one at `open`, or npos where none does.
  /// @param has_comment  set where there is one in between
  std::size_t afterBracket(std::size_t open, bool* has_comment) const;

  void replace(std::size_t begin, std::size_t end, std::string by);
  void insert(std::size_t at, std::string what) { replace(at, at, std::move(what)); }
  /// With all changes; of insertions at one place the first one stands first.
  /// @throws std::logic_error  two of them overlap
  std::string result() const;

 private:
  struct Change {
    std::size_t begin, end;
    std::string by;
  };

  std::string text_, line_end_;
  std::vector<Change> changes_;
};

}  // namespace planar_bin_picking
