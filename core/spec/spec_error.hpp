#pragma once
#include <stdexcept>
#include <string>

namespace flexopt {

/// The user's input is wrong. `pointer` is the JSON pointer of the culprit, `value` what stands
/// there, `rule` what would be right.
class SpecError : public std::runtime_error {
 public:
  SpecError(std::string pointer, std::string value, std::string rule);

  const std::string& pointer() const { return pointer_; }
  const std::string& value() const { return value_; }
  const std::string& rule() const { return rule_; }

 private:
  std::string pointer_, value_, rule_;
};

}  // namespace flexopt
