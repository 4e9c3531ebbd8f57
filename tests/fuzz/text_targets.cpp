// Readers of short texts, which need nothing of the mechanics.
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/spec/formula.hpp"
#include "core/spec/json_file.hpp"
#include "core/spec/quantity.hpp"
#include "results/server/guard.hpp"
#include "tests/fuzz/demands.hpp"
#include "tests/fuzz/targets.hpp"

namespace flexopt::fuzz {
namespace {

using nlohmann::json;

void formula(std::string_view text) {
  const std::vector<FormulaName> names{{"length", "m"}, {"width", "m"}, {"angle", "rad"},
                                       {"n", ""},       {"E", "Pa"},    {"mass", "kg"}};
  for (const BareNumbers bare : {BareNumbers::are_plain, BareNumbers::may_be_si})
    refusing([&] {
      const Formula formula(std::string(text), names, "/formula", bare);
      for (const double scale : {1.0, 0.0, -1e3}) {
        const std::array<double, 6> numbers{0.1 * scale, 0.03 * scale, 0.7 * scale,
                                            3 * scale,   2e11 * scale, 0.5 * scale};
        const auto value = formula.value(numbers);
        demand(!value || std::isfinite(*value), "a formula whose value is not finite");
        std::vector<double> slopes(formula.slots().size());
        const auto again = formula.gradient(numbers, slopes);
        if (!again) continue;
        demand(value && *value == *again, "a formula of two values");
        for (const double slope : slopes)
          demand(std::isfinite(slope), "a slope that is not finite");
      }
      formula.check_unit("m");
    });
}

void unit(std::string_view text) {
  const std::string word(text);
  if (const auto measure = measured(1, word)) {
    demand(std::isfinite(measure->value), "a unit that is not finite");
    demand(!describe(measure->dimension).empty(), "a dimension without words");
  }
  for (const char* wanted : {"m", "rad", "N m/rad", "1", "kg"})
    refusing([&] {
      demand(std::isfinite(parse_quantity(word, wanted, "/value")), "a quantity not finite");
    });
}

void assignment(std::string_view text) {
  refusing([&] {
    json document{{"stroke", {{"to", 1}}}, {"loads", json::array({1})}};
    apply_override(document, std::string(text));
    demand(!document.dump(-1, ' ', false, json::error_handler_t::replace).empty(), "nothing left");
  });
}

void request(std::string_view text) {
  const RequestText whole = read_request(text);
  demand(whole.state != RequestText::State::refused ||
             (whole.status >= 400 && whole.status < 600 && !whole.reason.empty()),
         "a refusal without status and reason");
  // what is whole was incomplete before its last byte
  if (whole.state == RequestText::State::whole)
    for (const std::size_t n : {text.size() - 1, text.size() / 2})
      demand(read_request(text.substr(0, n)).state == RequestText::State::incomplete,
             "a request that was whole before");
  static_cast<void>(refusal({std::string(text), std::string(text), std::string(text)}, 8000, "a"));
}

}  // namespace

const std::vector<Target>& text_targets() {
  static const std::vector<Target> all{
      {"formula", formula}, {"unit", unit}, {"set", assignment}, {"request", request}};
  return all;
}

}  // namespace flexopt::fuzz
