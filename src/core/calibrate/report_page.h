// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A page of HTML while it is written.

#include <iomanip>
#include <locale>
#include <sstream>
#include <string>

namespace planar_bin_picking {

/// Text for HTML; numbers with points, whatever the locale.
class Page {
 public:
  Page() { out_.imbue(std::locale::classic()); }
  template <class T>
  Page& operator<<(const T& value) {
    out_ << value;
    return *this;
  }
  Page& text(const std::string& raw) {
    for (const char c : raw) {
      if (c == '&')
        out_ << "&amp;";
      else if (c == '<')
        out_ << "&lt;";
      else if (c == '>')
        out_ << "&gt;";
      else if (c == '\'')
        out_ << "&#39;";
      else
        out_ << c;
    }
    return *this;
  }
  Page& number(double value, int digits = 4) {
    out_ << std::setprecision(digits) << value;
    return *this;
  }
  std::string str() const { return out_.str(); }

 private:
  std::ostringstream out_;
};

}  // namespace planar_bin_picking
