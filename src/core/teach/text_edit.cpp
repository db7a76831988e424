// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "teach/text_edit.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace planar_bin_picking {

TextEdit::TextEdit(std::string text) : text_(std::move(text)) {
  const std::size_t first = text_.find('\n');
  const bool windows = first != std::string::npos && first > 0 && text_[first - 1] == '\r';
  line_end_ = windows ? "\r\n" : "\n";
}

std::size_t TextEdit::lineBegin(std::size_t at) const {
  const std::size_t end = at == 0 ? std::string::npos : text_.rfind('\n', at - 1);
  return end == std::string::npos ? 0 : end + 1;
}

std::size_t TextEdit::lineAfter(std::size_t at) const {
  const std::size_t end = text_.find('\n', at);
  return end == std::string::npos ? text_.size() : end + 1;
}

bool TextEdit::isBlankOrComment(std::size_t line_begin) const {
  const std::size_t first = text_.find_first_not_of(" \t\r", line_begin);
  return first == std::string::npos || text_[first] == '\n' || text_[first] == '#';
}

std::size_t TextEdit::afterBracket(std::size_t open, bool* has_comment) const {
  int depth = 0;
  char quote = 0;
  for (std::size_t i = open; i < text_.size(); ++i) {
    const char c = text_[i];
    if (quote != 0) {
      if (c == '\\' && quote == '"') ++i;
      if (c == quote) quote = 0;
    } else if (c == '#' && (text_[i - 1] == ' ' || text_[i - 1] == '\n' || text_[i - 1] == '\t')) {
      *has_comment = true;
      i = lineAfter(i) - 1;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '[' || c == '{') {
      ++depth;
    } else if ((c == ']' || c == '}') && --depth == 0) {
      return i + 1;
    }
  }
  return std::string::npos;
}

void TextEdit::replace(std::size_t begin, std::size_t end, std::string by) {
  changes_.push_back({begin, end, std::move(by)});
}

std::string TextEdit::result() const {
  std::vector<Change> changes = changes_;
  std::stable_sort(changes.begin(), changes.end(),
                   [](const Change& a, const Change& b) { return a.begin < b.begin; });
  std::string result;
  std::size_t copied = 0;
  for (const Change& change : changes) {
    if (change.begin < copied) throw std::logic_error("changes of a text overlap");
    result += text_.substr(copied, change.begin - copied) + change.by;
    copied = change.end;
  }
  return result + text_.substr(copied);
}

}  // namespace planar_bin_picking
