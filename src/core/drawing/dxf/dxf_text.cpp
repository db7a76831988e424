// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/dxf/dxf_text.h"

#include <locale.h>
#include <stdlib.h>

#include <charconv>
#include <cmath>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

std::string quoted(std::string_view text) {
  constexpr std::size_t kMost = 40;  // enough to find it in the file
  return "\"" + std::string(text.substr(0, kMost)) + "\"";
}

/// The whole text as a number with a decimal point, whatever the process's locale.
bool parseReal(const std::string& text, double* value) {
  static const locale_t kClassic = newlocale(LC_ALL_MASK, "C", nullptr);
  char* end = nullptr;
  *value = strtod_l(text.c_str(), &end, kClassic);
  return !text.empty() && *end == '\0' && text.find_first_of("xX") == std::string::npos;
}

}  // namespace

void refuseLine(std::size_t line, const std::string& what) {
  throw std::runtime_error("line " + std::to_string(line) + ": " + what);
}

DxfText::DxfText(std::string_view content) : content_(content) {
  const auto refuse = [](const char* what) { throw std::runtime_error(what); };
  if (content.empty()) refuse("is empty; export the drawing again");
  if (content.substr(0, 18) == "AutoCAD Binary DXF")
    refuse("is a binary DXF file; save the drawing as an ASCII DXF file");
  if (content.substr(0, 4) == "AC10")
    refuse("is a DWG file; save the drawing as an ASCII DXF file");
  if (content.find('\0') != std::string_view::npos)
    refuse("is not a text file; save the drawing as an ASCII DXF file");
  if (content.substr(0, 3) == "\xef\xbb\xbf") content_.remove_prefix(3);  // byte order mark
  nextGroup(&ahead_);
}

bool DxfText::nextLine(std::string_view* line) {
  if (position_ >= content_.size()) return false;
  const std::size_t begin = position_;
  const std::size_t end = std::min(content_.find_first_of("\r\n", begin), content_.size());
  *line = content_.substr(begin, end - begin);
  // \n, \r and \r\n end a line, and \r\r\n, which text-mode copies of \r\n leave behind.
  const std::size_t after = std::min(content_.find_first_not_of('\r', end), content_.size());
  if (after < content_.size() && content_[after] == '\n') {
    position_ = after + 1;
  } else {
    position_ = end + 1;
  }
  ++line_;
  return true;
}

void DxfText::nextGroup(DxfGroup* group) {
  std::string_view code, value;
  while (nextLine(&code)) {
    code = trimmed(code);
    const auto parsed = std::from_chars(code.data(), code.data() + code.size(), group->code);
    const bool rest_is_blank =
        content_.find_first_not_of(" \t\r\n", std::min(position_, content_.size())) ==
        std::string_view::npos;
    if (code.empty() && rest_is_blank) break;
    if (code.empty() || parsed.ec != std::errc() || parsed.ptr != code.data() + code.size()) {
      refuseLine(line_, any_ ? quoted(code) + " is no group code; the file is damaged"
                             : "this is not a DXF file");
    }
    if (!nextLine(&value)) break;
    any_ = true;
    if (group->code == 999) continue;  // a comment
    group->value = trimmed(value);
    group->line = line_;
    return;
  }
  throw std::runtime_error("ends without its EOF line: it is truncated; copy or export it again");
}

bool DxfText::next(DxfRecord* record) {
  record->clear();
  if (ahead_.line == 0) return false;
  record->push_back(ahead_);
  if (ahead_.code == 0 && ahead_.value == "EOF") {
    ahead_.line = 0;
    return true;
  }
  for (nextGroup(&ahead_); ahead_.code != 0 && ahead_.code != 9; nextGroup(&ahead_)) {
    record->push_back(ahead_);
  }
  return true;
}

double realOf(const DxfGroup& group, std::string_view owner) {
  std::string text(group.value);
  // A comma is the decimal sign of whoever wrote the file: DXF separates nothing by commas.
  const std::size_t comma = text.find(',');
  if (comma != std::string::npos && text.find('.') == std::string::npos) text[comma] = '.';
  double value = 0.0;
  if (!parseReal(text, &value) || !std::isfinite(value)) {
    refuseLine(group.line, quoted(group.value) + " in this " + std::string(owner) +
                               " is not a number; the file is damaged");
  }
  if (std::fpclassify(value) == FP_SUBNORMAL) {
    refuseLine(group.line, quoted(group.value) + " in this " + std::string(owner) +
                               " is too small for a length or an angle; the file is damaged");
  }
  return value;
}

int integerOf(const DxfGroup& group, std::string_view owner) {
  int value = 0;
  const char* const end = group.value.data() + group.value.size();
  const auto parsed = std::from_chars(group.value.data(), end, value);
  if (group.value.empty() || parsed.ec != std::errc() || parsed.ptr != end) {
    refuseLine(group.line, quoted(group.value) + " in this " + std::string(owner) +
                               " is not a whole number; the file is damaged");
  }
  return value;
}

const DxfGroup* findGroup(const DxfRecord& record, int code) {
  for (std::size_t i = 1; i < record.size(); ++i) {
    if (record[i].code == code) return &record[i];
  }
  return nullptr;
}

double realOf(const DxfRecord& record, int code, double otherwise) {
  const DxfGroup* group = findGroup(record, code);
  return group == nullptr ? otherwise : realOf(*group, record.front().value);
}

int integerOf(const DxfRecord& record, int code, int otherwise) {
  const DxfGroup* group = findGroup(record, code);
  return group == nullptr ? otherwise : integerOf(*group, record.front().value);
}

std::string_view textOf(const DxfRecord& record, int code, std::string_view otherwise) {
  const DxfGroup* group = findGroup(record, code);
  return group == nullptr ? otherwise : group->value;
}

}  // namespace planar_bin_picking
