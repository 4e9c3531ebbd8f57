#pragma once
// Text files of other programs, read line by line.
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace flexopt {

class NumberedLines {
 public:
  /// Throws SpecError where there is no such file.
  explicit NumberedLines(const std::string& file);

  /// Goes to the next line; false behind the last one.
  bool next();
  /// The same, but the file must have one.
  void need();
  /// The line without blanks at its ends.
  std::string_view text() const { return text_; }
  /// Its numbers, which blanks or commas separate: at least so many. Valid until the next call.
  const std::vector<double>& numbers(std::size_t least);
  /// A number that must be a whole one and fit into an int.
  int whole(double number) const;
  /// Throws SpecError at this line; `of_file`: about the file as a whole.
  [[noreturn]] void fail(const std::string& rule, bool of_file = false) const;

 private:
  std::string file_, line_;
  std::ifstream stream_;
  std::string_view text_;
  std::vector<double> numbers_;
  int number_ = 0;
};

/// Without blanks at its ends; in capitals.
std::string_view trimmed(std::string_view text);
std::string capitals(std::string_view text);

}  // namespace flexopt
