// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "base/yaml_text.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <locale>
#include <set>
#include <sstream>

namespace planar_bin_picking {
namespace {

/// Bytes of the UTF-8 character that starts at `at`; 0 where there is none.
std::size_t characterLength(const std::string& text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(at);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xC2 && first < 0xE0   ? 2
                             : first >= 0xE0 && first < 0xF0 ? 3
                             : first >= 0xF0 && first < 0xF5 ? 4
                                                             : 0;
  if (length == 0 || at + length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(at + i) & 0xC0) != 0x80) return 0;
  }
  // The second byte of some is limited: no longer forms, no halves of pairs, nothing over U+10FFFF.
  const unsigned char second = byte(at + 1);
  const bool beyond = (first == 0xE0 && second < 0xA0) || (first == 0xED && second > 0x9F) ||
                      (first == 0xF0 && second < 0x90) || (first == 0xF4 && second > 0x8F);
  return beyond ? 0 : length;
}

bool isControl(const std::string& text, std::size_t at, std::size_t length) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  if (length == 1) return byte(at) < 0x20 || byte(at) == 0x7F;
  if (length == 2) return byte(at) == 0xC2 && byte(at + 1) < 0xA0;
  // Line and paragraph separators, and the mark that some editors put before a text.
  const std::string character = text.substr(at, length);
  return character == "\u2028" || character == "\u2029" || character == "\uFEFF";
}

/// Whether a single-quoted scalar can hold it as it stands.
bool isPrintable(const std::string& text) {
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = characterLength(text, i);
    if (length == 0 || isControl(text, i, length)) return false;
    i += length;
  }
  return true;
}

bool isPlainWord(const std::string& text) {
  static const std::set<std::string> kTaken = {"true", "false", "yes", "no", "on",
                                               "off",  "null",  "y",   "n"};
  const auto is = [](char c, const char* others) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
           std::string(others).find(c) != std::string::npos;
  };
  if (text.empty() || !is(text[0], "_")) return false;
  std::string lower = text;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return kTaken.count(lower) == 0 &&
         std::all_of(text.begin(), text.end(), [&](char c) { return is(c, "_-.@0123456789"); });
}

std::string escaped(unsigned code) {
  constexpr char kDigits[] = "0123456789ABCDEF";
  std::string digits;
  for (int shift = code < 0x100 ? 4 : 12; shift >= 0; shift -= 4)
    digits += kDigits[(code >> shift) & 15];
  return (code < 0x100 ? "\\x" : "\\u") + digits;
}

std::string inDoubleQuotes(const std::string& text) {
  std::string out = "\"";
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = std::max<std::size_t>(1, characterLength(text, i));
    const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[i + k]); };
    const bool valid = characterLength(text, i) > 0;
    if (valid && !isControl(text, i, length)) {
      if (text[i] == '"' || text[i] == '\\') out += '\\';
      out += text.substr(i, length);
    } else if (length == 1) {  // also a byte of whatever code page
      out += escaped(byte(0));
    } else if (length == 2) {
      out += escaped((byte(0) & 0x1Fu) << 6 | (byte(1) & 0x3Fu));
    } else {
      out += escaped((byte(0) & 0x0Fu) << 12 | (byte(1) & 0x3Fu) << 6 | (byte(2) & 0x3Fu));
    }
    i += length;
  }
  return out + "\"";
}

template <class Values, class Text>
std::string list(const Values& values, Text&& text) {
  std::string out = "[";
  for (std::size_t i = 0; i < values.size(); ++i) out += (i == 0 ? "" : ", ") + text(values[i]);
  return out + "]";
}

}  // namespace

std::string yamlText(const std::string& text) {
  if (isPlainWord(text)) return text;
  if (!isPrintable(text)) return inDoubleQuotes(text);
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("''") : std::string(1, c);
  return out + "'";
}

std::string yamlNumber(double value) {
  if (std::isnan(value)) return ".nan";
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out.precision(10);
  out << value;
  return out.str();
}

std::string yamlNumber(double value, int decimals) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out.setf(std::ios::fixed);
  out.precision(decimals);
  out << value;
  return out.str();
}

std::string yamlList(const std::vector<std::string>& texts) {
  return list(texts, [](const std::string& text) { return yamlText(text); });
}

std::string yamlList(const std::vector<double>& values, int decimals) {
  return list(values, [&](double value) { return yamlNumber(value, decimals); });
}

}  // namespace planar_bin_picking
