// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/dxf/dxf_names.h"

#include <fnmatch.h>
#include <iconv.h>

#include <algorithm>
#include <array>
#include <optional>

namespace planar_bin_picking {
namespace {

bool isAscii(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](unsigned char c) { return c < 128; });
}

/// Converts by the C library's tables; nothing where it has none or the bytes do not fit.
std::optional<std::string> convert(std::string_view bytes, const std::string& encoding) {
  const iconv_t table = iconv_open("UTF-8", encoding.c_str());
  if (table == reinterpret_cast<iconv_t>(-1)) return std::nullopt;
  std::string in(bytes), out(4 * bytes.size() + 4, '\0');
  char *from = in.data(), *to = out.data();
  std::size_t from_left = in.size(), to_left = out.size();
  const bool good = iconv(table, &from, &from_left, &to, &to_left) != static_cast<std::size_t>(-1);
  iconv_close(table);
  if (!good) return std::nullopt;
  out.resize(out.size() - to_left);
  return out;
}

std::string lowerAscii(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return lower;
}

std::string encodingOf(std::string_view code_page, std::string_view version) {
  if (version >= "AC1021" && version.size() == 6) return "UTF-8";  // AutoCAD 2007 and later
  const std::string page = lowerAscii(code_page);
  for (const char* prefix : {"ansi_", "dos"}) {
    if (page.rfind(prefix, 0) == 0) return "CP" + page.substr(std::string(prefix).size());
  }
  if (page.rfind("iso8859", 0) == 0) return "ISO-8859" + page.substr(7);
  if (page == "mac-roman") return "MACINTOSH";
  if (page == "ascii" || page.empty()) return "CP1252";
  return page;
}

void appendUtf8(char32_t c, std::string* text) {
  const auto put = [&](char32_t byte) { text->push_back(static_cast<char>(byte)); };
  if (c < 0x80) return put(c);
  if (c < 0x800) {
    put(0xC0 | (c >> 6));
  } else if (c < 0x10000) {
    put(0xE0 | (c >> 12));
    put(0x80 | ((c >> 6) & 0x3F));
  } else {
    put(0xF0 | (c >> 18));
    put(0x80 | ((c >> 12) & 0x3F));
    put(0x80 | ((c >> 6) & 0x3F));
  }
  put(0x80 | (c & 0x3F));
}

/// One character at `i`, which moves behind it; a byte that is no UTF-8 stands for itself.
char32_t nextCharacter(std::string_view text, std::size_t* i) {
  const auto byte = [&](std::size_t k) -> unsigned char {
    return k < text.size() ? static_cast<unsigned char>(text[k]) : 0;
  };
  const unsigned char first = byte(*i);
  const int more = first >= 0xF0 ? 3 : first >= 0xE0 ? 2 : first >= 0xC0 ? 1 : 0;
  char32_t c = more == 0 ? first : first & (0x3F >> more);
  for (int k = 1; k <= more; ++k) {
    if ((byte(*i + k) & 0xC0) != 0x80) {
      ++*i;
      return first;
    }
    c = (c << 6) | (byte(*i + k) & 0x3F);
  }
  *i += 1 + more;
  return c;
}

std::optional<unsigned> hexadecimal(std::string_view text) {
  unsigned value = 0;
  for (const char c : text) {
    const std::size_t digit = std::string_view("0123456789abcdef0123456789ABCDEF").find(c);
    if (digit == std::string_view::npos) return std::nullopt;
    value = 16 * value + static_cast<unsigned>(digit % 16);
  }
  return value;
}

/// The text of \M+NXXXX: two bytes of the N-th of the code pages for Chinese, Japanese and Korean.
std::optional<std::string> multiByte(std::string_view digits) {
  static const std::array<const char*, 5> kPages = {"CP932", "CP950", "CP949", "JOHAB", "CP936"};
  const auto page = hexadecimal(digits.substr(0, 1)), bytes = hexadecimal(digits.substr(1));
  if (!page || !bytes || *page < 1 || *page > kPages.size()) return std::nullopt;
  std::string two;
  if (*bytes > 0xFF) two.push_back(static_cast<char>(*bytes >> 8));
  two.push_back(static_cast<char>(*bytes & 0xFF));
  return convert(two, kPages[*page - 1]);
}

std::string resolveEscapes(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const std::string_view rest = std::string_view(text).substr(i);
    const std::string_view mark = rest.substr(0, 3);
    if ((mark == "\\U+" || mark == "\\u+") && rest.size() >= 7) {
      auto c = hexadecimal(rest.substr(3, 4));
      std::size_t used = 7;
      // Two halves make one character beyond the first 65536.
      if (c && *c >= 0xD800 && *c < 0xDC00 && rest.size() >= 14 && rest.substr(7, 3) == mark) {
        const auto low = hexadecimal(rest.substr(10, 4));
        if (low && *low >= 0xDC00 && *low < 0xE000) {
          c = 0x10000 + ((*c - 0xD800) << 10) + (*low - 0xDC00);
          used = 14;
        }
      }
      if (c) {
        appendUtf8(*c, &out);
        i += used;
        continue;
      }
    }
    if ((mark == "\\M+" || mark == "\\m+") && rest.size() >= 8) {
      if (const auto decoded = multiByte(rest.substr(3, 5))) {
        out += *decoded;
        i += 8;
        continue;
      }
    }
    out.push_back(text[i++]);
  }
  return out;
}

/// The capital letter, where there are two cases and one has a number of its own.
char32_t capital(char32_t c) {
  if (c < 0x80) return c >= 'a' && c <= 'z' ? c - 32 : c;
  if (c >= 0xE0 && c <= 0xFE && c != 0xF7) return c - 32;
  if (c == 0xFF) return 0x178;
  // Latin Extended-A: pairs; where they begin changes twice.
  if ((c >= 0x139 && c <= 0x148) || (c >= 0x179 && c <= 0x17E)) return c % 2 == 0 ? c - 1 : c;
  if (c >= 0x100 && c <= 0x177 && c != 0x131 && c != 0x138) return c % 2 == 1 ? c - 1 : c;
  if (c >= 0x1E00 && c <= 0x1EFF) return c % 2 == 1 && (c < 0x1E96 || c > 0x1E9F) ? c - 1 : c;
  if (c == 0x3C2) return 0x3A3;
  if (c >= 0x3B1 && c <= 0x3CB) return c - 32;
  if (c == 0x3AC) return 0x386;
  if (c >= 0x3AD && c <= 0x3AF) return c - 37;
  if (c == 0x3CC) return 0x38C;
  if (c == 0x3CD || c == 0x3CE) return c - 63;
  if (c >= 0x430 && c <= 0x44F) return c - 32;
  if (c >= 0x450 && c <= 0x45F) return c - 80;
  if (c >= 0x460 && c <= 0x4FF && !(c >= 0x482 && c <= 0x489) && !(c >= 0x4C0 && c <= 0x4CF))
    return c % 2 == 1 ? c - 1 : c;
  return c;
}

}  // namespace

DxfNames::DxfNames(std::string_view code_page, std::string_view version)
    : encoding_(encodingOf(code_page, version)) {}

std::string DxfNames::decode(std::string_view bytes) const {
  std::string text(bytes);
  if (!isAscii(bytes)) {
    // Many programs write UTF-8 and state some code page. In one with a byte for each letter, text
    // that happens to be UTF-8 makes no words; the others need two bytes, where that may happen.
    const bool two_bytes = encoding_ == "CP932" || encoding_ == "CP936" || encoding_ == "CP949" ||
                           encoding_ == "CP950";
    auto decoded = convert(bytes, two_bytes ? encoding_ : "UTF-8");
    if (!decoded) decoded = convert(bytes, two_bytes ? "UTF-8" : encoding_);
    if (!decoded) decoded = convert(bytes, "CP1252");
    if (decoded) {
      text = *decoded;
    } else {
      std::replace_if(
          text.begin(), text.end(), [](unsigned char c) { return c >= 128; }, '?');
    }
  }
  return text.find('\\') == std::string::npos ? text : resolveEscapes(text);
}

std::string upperCase(std::string_view utf8) {
  std::string out;
  out.reserve(utf8.size());
  for (std::size_t i = 0; i < utf8.size();) {
    const std::size_t begin = i;
    const char32_t c = nextCharacter(utf8, &i);
    if (c >= 0x80 && i == begin + 1) {
      out.push_back(utf8[begin]);
    } else {
      appendUtf8(capital(c), &out);
    }
  }
  return out;
}

bool matchesPattern(std::string_view text, std::string_view pattern) {
  std::string wanted;
  for (const char c : upperCase(pattern)) {
    if (c == '?' || c == '[' || c == '\\') wanted += '\\';  // names may have these in them
    wanted += c;
  }
  return fnmatch(wanted.c_str(), upperCase(text).c_str(), 0) == 0;
}

bool matchesAny(std::string_view name, const std::vector<std::string>& patterns) {
  std::string_view tail = name;
  const std::size_t bar = name.find_last_of('|'), dollar = name.find_last_of('$');
  if (bar != std::string_view::npos) tail = name.substr(bar + 1);
  if (dollar != std::string_view::npos && dollar > 0) {
    const std::size_t before = name.find_last_not_of("0123456789", dollar - 1);
    if (before != std::string_view::npos && name[before] == '$' && before + 1 < dollar)
      tail = name.substr(dollar + 1);
  }
  return std::any_of(patterns.begin(), patterns.end(), [&](const std::string& pattern) {
    return matchesPattern(name, pattern) ||
           (tail.size() < name.size() && matchesPattern(tail, pattern));
  });
}

}  // namespace planar_bin_picking
