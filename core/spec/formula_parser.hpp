#pragma once
// Parser that turns the text of a formula into its steps. Private to the formula's own sources.
#include <string_view>

#include "core/spec/formula.hpp"
#include "core/spec/spec_error.hpp"

namespace flexopt {

enum class FormulaOp : std::uint8_t {
  constant,
  name,
  minus,
  negation,
  function,  ///< of one argument
  whole_power,
  add,
  subtract,
  multiply,
  divide,
  power,
  less,
  less_equal,
  greater,
  greater_equal,
  equal,
  unequal,
  both,
  either,
  least,
  largest,
  angle,  ///< atan2
  choice
};

/// What a function of one argument does to dimensions.
enum class FormulaMeasure : std::uint8_t {
  keeps,    ///< abs, rint: that of the argument
  forgets,  ///< sign: any argument, a plain number
  root,     ///< sqrt
  plain,    ///< exp, sin, …: of plain numbers or angles
  angle     ///< asin, …: an angle, of plain numbers
};

struct FormulaFunction {
  std::string_view name;
  double (*value)(double x);
  double (*derivative)(double x, double y);  ///< y: the value; null: zero everywhere
  FormulaMeasure measure;
};

constexpr std::size_t longest_formula = 10000;  ///< letters

/// A function of several arguments: how many, and the operation that joins them.
struct ListFunction {
  std::string_view name;
  FormulaOp op;
  std::size_t most;  ///< arguments
};

/// The function of this name; null where there is none.
const FormulaFunction* find_function(std::string_view name);
const ListFunction* find_list_function(std::string_view name);

std::vector<std::string> function_names();

/// The value of a step that is no name.
double value_of_step(const Formula::Step& step, double a, double b, double c);

/// Recursive descent; every method reads what its name says from the token at hand on.
class FormulaParser {
 public:
  FormulaParser(Formula& formula, const std::vector<FormulaName>& names, BareNumbers bare);
  void parse();

 private:
  enum class Kind { number, name, sign, end };
  struct Token {
    Kind kind = Kind::end;
    std::string_view text;  ///< a number's without its unit
    std::size_t begin = 0, end = 0;
    double number = 0;
    std::string unit;       ///< of a number; empty: none
    bool fraction = false;  ///< a number with a decimal point or an exponent
  };

  /// A part of the formula: its step, what it measures, and where it stands.
  struct Part {
    enum class Measure {
      bare,   ///< numbers without unit alone
      known,  ///< of `dimension`
      loose   ///< of `dimension`, or any other where a bare factor stands for a quantity
    };
    int step = 0;
    Measure measure = Measure::bare;
    Dimension dimension;
    bool fraction = false;  ///< of a bare one: may stand for a quantity
    std::size_t begin = 0, end = 0;
  };

  void read_tokens();
  Token read_number(std::size_t begin) const;
  void read_unit(Token& number) const;

  Part choice();
  Part binary(int level);  ///< signs of this level and of higher ones
  Part factor();           ///< with its signs
  Part power();
  Part operand();
  Part number();
  Part name();
  Part defined(const Formula& formula, const Token& name);
  int slot_of(const FormulaName& name);  ///< its place among the formula's own
  Part call();

  const Token& token() const { return tokens_[at_]; }
  bool is(std::string_view sign) const;
  bool accept(std::string_view sign);
  void expect(std::string_view sign, const char* why);

  Part make(FormulaOp op, const Part& a, const Part& b);
  Part make(Formula::Step step, std::size_t begin, std::size_t end);
  static Formula::Step unary(FormulaOp op, const Part& argument) {
    return {.op = op, .a = argument.step, .b = argument.step, .c = argument.step};
  }
  Part alike(FormulaOp op, const Part& a, const Part& b, const char* verb);
  void measure_alike(Part& result, const Part& a, const Part& b, const char* verb) const;
  void measure_product(Part& result, const Part& a, const Part& b, bool quotient) const;
  void measure_power(Part& result, const Part& base, const Part& exponent) const;
  Part apply(const FormulaFunction& function, const Part& argument, const Token& name);

  bool is_constant(const Part& part) const;
  std::string shown(const Part& part) const;
  SpecError refuse(const std::string& rule) const;
  SpecError no_formula(const std::string& what, std::size_t at) const;
  SpecError unknown(const Token& name) const;
  SpecError unexpected() const;

  Formula& formula_;
  const std::vector<FormulaName>& names_;
  bool may_be_si_;
  bool has_unit_ = false, has_fraction_ = false;
  std::vector<Token> tokens_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

}  // namespace flexopt
