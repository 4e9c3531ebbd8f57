#pragma once
// Formulas as users write them: "2*outer_width + inner_width", "length/2 + 5 mm". Parsed once,
// then evaluated as often as wanted on numbers that lie in slots.
//
//   + - * / ^          ^ binds from the right, a sign less than ^: -x^2 = -(x^2)
//   < <= > >= == !=    1 or 0; not chained
//   && || !  a ? b : c
//   min max sum avg (any number of arguments), abs sign rint round sqrt exp ln log (both natural)
//   log2 log10 sin cos tan asin acos atan atan2 sinh cosh tanh asinh acosh atanh, pi
//   5 mm   3 [N/m]     a number with its unit: one symbol, or any unit in brackets
//   'load.-ux'         a name with signs in it, in quotes
//
// Dimensions. The sides of a sum, a comparison, of min, max, sum, avg, atan2 and of ?: have one
// dimension; arguments of sin, exp and the like are plain numbers or angles, which count as
// numbers; an exponent is a plain number, and a constant where its base has a dimension. Values
// are in SI.
//   A number without unit, and what is made of such numbers alone, is bare: it takes the dimension
// of the other side of a sum or comparison, and that of the formula's place; as a factor it is a
// plain number. One exception, BareNumbers::may_be_si, for formulas that know no units: "2e11/E"
// means 2e11 Pa. There, in a formula without any unit, a factor written with a decimal point or an
// exponent may stand for a quantity in SI. What it multiplies then fits any dimension, and a
// formula with such numbers fits any place.
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/spec/quantity.hpp"

namespace flexopt {

class Formula;

/// A name that formulas may use.
struct FormulaName {
  std::string name;
  std::string unit;  ///< SI unit of its number; empty: it is a bare number
  /// What the name stands for, of other names that the formula may use: it counts as written there.
  std::shared_ptr<const Formula> definition = nullptr;
};

enum class BareNumbers { are_plain, may_be_si };

enum class FormulaOp : std::uint8_t;
struct FormulaFunction;

class Formula {
 public:
  /// Slot i holds the number of names[i]. `pointer` is the JSON pointer of the text. Throws
  /// SpecError with the position (from 1) for bad syntax, unknown names and units, dimensions that
  /// do not fit, and for texts that are too long (10 000 letters) or nested too deeply (100
  /// parentheses).
  Formula(std::string text, const std::vector<FormulaName>& names, std::string pointer,
          BareNumbers bare = BareNumbers::are_plain);

  const std::string& text() const { return text_; }
  const std::string& pointer() const { return pointer_; }
  /// Slots that the formula uses, ascending.
  const std::vector<int>& slots() const { return slots_; }
  /// Names of the slots, and the SI units as a text writes them behind a number (" [m]"), in the
  /// order of slots().
  const std::vector<std::string>& names() const { return names_; }
  const std::vector<std::string>& units() const { return units_; }
  /// Dimension of the value; nothing where the value is a bare number.
  const std::optional<Dimension>& dimension() const { return dimension_; }
  /// Whether it fits a place of any dimension, because a number in it may be a quantity in SI.
  bool fits_anywhere() const { return fits_anywhere_; }
  /// Renumbers the slots: i becomes to[i], which must ascend.
  void move_to(std::span<const int> to);
  /// Throws SpecError where a value of this SI unit is wanted and the formula's has another
  /// dimension.
  void check_unit(const std::string& unit) const;

  /// The value; nothing where it is not finite (1/0, sqrt(-1)). Thread-safe.
  std::optional<double> value(std::span<const double> numbers) const;
  /// The value, and its exact derivatives along `slots()`; at a kink those of the branch that gives
  /// the value. Nothing where one of them is not finite. Thread-safe.
  std::optional<double> gradient(std::span<const double> numbers, std::span<double> slopes) const;

  /// The formula on numbers that carry derivatives, such as Dual<n>: anything with a member `value`
  /// that is multiplied by and added to numbers.
  template <class Scalar>
  std::optional<Scalar> evaluate(std::span<const Scalar> numbers) const {
    std::vector<double> values, slopes(slots_.size());
    for (const Scalar& x : numbers) values.push_back(x.value);
    const std::optional<double> value = gradient(values, slopes);
    if (!value) return std::nullopt;
    Scalar result(*value);
    for (std::size_t i = 0; i < slots_.size(); ++i)
      result += slopes[i] * (numbers[slots_[i]] - values[slots_[i]]);
    return result;
  }

  /// A step of the evaluation.
  struct Step {
    FormulaOp op{};
    int a = 0, b = 0, c = 0;  ///< operands: earlier steps; one of them again where there are fewer
    int slot = 0;             ///< of a name: index into slots()
    double number = 0;        ///< of a constant; the exponent of a whole power
    const FormulaFunction* function = nullptr;
  };

 private:
  friend class FormulaParser;
  void values(std::span<const double> numbers, double* steps) const;

  std::string text_, pointer_;
  std::vector<int> slots_;
  std::vector<std::string> names_, units_;
  std::vector<Step> steps_;  ///< the last one is the value
  std::optional<Dimension> dimension_;
  bool fits_anywhere_ = false;
};

/// Whether the word means something in every formula, so that no name may be called so: a function
/// or pi.
bool is_formula_word(std::string_view word);

/// Rule that a formula breaks which uses none of the names.
std::string uses_no_name(const std::vector<FormulaName>& names);

}  // namespace flexopt
