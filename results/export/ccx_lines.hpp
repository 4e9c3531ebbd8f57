#pragma once
// Lines of a deck of CalculiX.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <string>
#include <vector>

#include "core/math/types.hpp"

namespace flexopt {

/// CalculiX reads 20 characters of a number: 12 digits with sign and exponent.
class CcxLines {
 public:
  template <class... T>
  void line(fmt::format_string<T...> format, T&&... values) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<T>(values)...);
    text_ += '\n';
  }
  void numbers(const std::vector<int>& list) {
    for (std::size_t k = 0; k < list.size(); k += 12) {
      const auto begin = list.begin() + static_cast<std::ptrdiff_t>(k);
      const auto end = list.begin() + static_cast<std::ptrdiff_t>(std::min(k + 12, list.size()));
      line("{},", fmt::join(begin, end, ", "));
    }
  }
  std::string text() && { return std::move(text_); }

 private:
  std::string text_;
};

/// Text of a name on one line, for use in comments.
std::string one_line(std::string text);

/// One term of an equation: factor times a degree of freedom of a node.
struct CcxTerm {
  int node = 0, dof = 0;
  double factor = 0;
};
/// The sum of the terms is zero; the first depends on the others.
void write_equation(const std::vector<CcxTerm>& terms, CcxLines& deck);

/// Terms of a · u of a node; a unit vector, the largest component first.
std::vector<CcxTerm> terms_along(int node, const Vector3d& axis);

}  // namespace flexopt
