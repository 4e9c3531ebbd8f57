#include "optim/job/expression_bytecode.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <string>

namespace flexopt {
namespace {

using std::numbers::ln10;
using std::numbers::ln2;

double plus(double x) { return x; }
double minus(double x) { return -x; }

double sign(double x) { return x < 0 ? -1 : x > 0 ? 1 : 0; }

/// d f / d x of the parser's functions of one argument, y = f(x).
struct Function {
  const char* name;
  double (*derivative)(double x, double y);
};
constexpr Function functions[] = {
    {"sin", [](double x, double) { return std::cos(x); }},
    {"cos", [](double x, double) { return -std::sin(x); }},
    {"tan", [](double, double y) { return 1 + y * y; }},
    {"asin", [](double x, double) { return 1 / std::sqrt(1 - x * x); }},
    {"acos", [](double x, double) { return -1 / std::sqrt(1 - x * x); }},
    {"atan", [](double x, double) { return 1 / (1 + x * x); }},
    {"sinh", [](double x, double) { return std::cosh(x); }},
    {"cosh", [](double x, double) { return std::sinh(x); }},
    {"tanh", [](double, double y) { return 1 - y * y; }},
    {"asinh", [](double x, double) { return 1 / std::sqrt(x * x + 1); }},
    {"acosh", [](double x, double) { return 1 / std::sqrt(x * x - 1); }},
    {"atanh", [](double x, double) { return 1 / (1 - x * x); }},
    {"exp", [](double, double y) { return y; }},
    {"ln", [](double x, double) { return 1 / x; }},
    {"log", [](double x, double) { return 1 / x; }},
    {"log2", [](double x, double) { return 1 / (x * ln2); }},
    {"log10", [](double x, double) { return 1 / (x * ln10); }},
    {"sqrt", [](double, double y) { return 0.5 / y; }},
    {"abs", [](double x, double) { return sign(x); }},
    {"sign", [](double, double) { return 0.0; }},
    {"rint", [](double, double) { return 0.0; }},
};

/// The parser's name of a function in its bytecode.
std::string name_of(const mu::Parser& parser, const mu::SToken& token) {
  const auto address = reinterpret_cast<void*>(token.Fun.cb._pRawFun);
  for (const auto& [name, callback] : parser.GetFunDef())
    if (callback.GetAddr() == address) return name;
  return address == reinterpret_cast<void*>(&minus) ? "-" : "+";
}

DualValue call_one(const std::string& name, const mu::SToken& token, const DualValue& x) {
  if (name == "-") return {-x.value, -x.gradient};
  if (name == "+") return x;
  const auto found = std::find_if(std::begin(functions), std::end(functions),
                                  [&](const Function& f) { return name == f.name; });
  assert(found != std::end(functions));
  const double y = token.Fun.cb.call_fun<1>(x.value);
  // What does not depend on a variable has no slope, however steep the function is there.
  if (x.gradient.isZero(0)) return {y, VectorXd::Zero(x.gradient.size())};
  return {y, found->derivative(x.value, y) * x.gradient};
}

/// Functions of several arguments: atan2, min, max, sum, avg.
DualValue call_many(const std::string& name, const DualValue* x, int count) {
  if (name == "atan2") {
    const double y = x[0].value, c = x[1].value, r2 = y * y + c * c;
    return {std::atan2(y, c), (c * x[0].gradient - y * x[1].gradient) / r2};
  }
  DualValue result = x[0];
  for (int i = 1; i < count; ++i) {
    if (name == "min" && x[i].value < result.value) result = x[i];
    if (name == "max" && x[i].value > result.value) result = x[i];
    if (name == "sum" || name == "avg")
      result.value += x[i].value, result.gradient += x[i].gradient;
  }
  if (name == "avg") result.value /= count, result.gradient /= count;
  return result;
}

DualValue power(const DualValue& a, const DualValue& b) {
  const double y = std::pow(a.value, b.value);
  VectorXd gradient = VectorXd::Zero(a.gradient.size());
  if (!a.gradient.isZero(0) && b.value != 0)
    gradient += b.value * std::pow(a.value, b.value - 1) * a.gradient;
  if (!b.gradient.isZero(0)) gradient += y * std::log(a.value) * b.gradient;
  return {y, gradient};
}

DualValue binary(mu::ECmdCode code, const DualValue& a, const DualValue& b) {
  const auto truth = [&](bool holds) {
    return DualValue{holds ? 1.0 : 0.0, VectorXd::Zero(a.gradient.size())};
  };
  switch (code) {
    case mu::cmADD:
      return {a.value + b.value, a.gradient + b.gradient};
    case mu::cmSUB:
      return {a.value - b.value, a.gradient - b.gradient};
    case mu::cmMUL:
      return {a.value * b.value, b.value * a.gradient + a.value * b.gradient};
    case mu::cmDIV:
      return {a.value / b.value, (a.gradient - a.value / b.value * b.gradient) / b.value};
    case mu::cmPOW:
      return power(a, b);
    case mu::cmLE:
      return truth(a.value <= b.value);
    case mu::cmGE:
      return truth(a.value >= b.value);
    case mu::cmNEQ:
      return truth(a.value != b.value);
    case mu::cmEQ:
      return truth(a.value == b.value);
    case mu::cmLT:
      return truth(a.value < b.value);
    case mu::cmGT:
      return truth(a.value > b.value);
    case mu::cmLAND:
      return truth(a.value != 0 && b.value != 0);
    default:
      assert(code == mu::cmLOR);
      return truth(a.value != 0 || b.value != 0);
  }
}

}  // namespace

void define_signs(mu::Parser& parser) {
  parser.ClearInfixOprt();
  parser.DefineInfixOprt("-", minus);
  parser.DefineInfixOprt("+", plus);
}

DualValue run_bytecode(const mu::Parser& parser, const std::vector<double>& variables) {
  const auto n = static_cast<Eigen::Index>(variables.size());
  const VectorXd zero = VectorXd::Zero(n);
  std::vector<DualValue> stack;
  const auto pop = [&] {
    DualValue top = std::move(stack.back());
    stack.pop_back();
    return top;
  };
  const auto variable = [&](const mu::SToken& token) {
    return DualValue{*token.Val.ptr, VectorXd::Unit(n, token.Val.ptr - variables.data())};
  };
  for (const mu::SToken* token = parser.GetByteCode().GetBase(); token->Cmd != mu::cmEND; ++token) {
    switch (token->Cmd) {
      case mu::cmVAL:
        stack.push_back({token->Val.data2, zero});
        break;
      case mu::cmVAR:
        stack.push_back(variable(*token));
        break;
      case mu::cmVARPOW2:
      case mu::cmVARPOW3:
      case mu::cmVARPOW4: {
        const int k = 2 + (token->Cmd - mu::cmVARPOW2);
        const DualValue x = variable(*token);
        stack.push_back({std::pow(x.value, k), k * std::pow(x.value, k - 1) * x.gradient});
        break;
      }
      case mu::cmVARMUL: {
        const DualValue x = variable(*token);
        stack.push_back(
            {x.value * token->Val.data + token->Val.data2, token->Val.data * x.gradient});
        break;
      }
      case mu::cmIF:
        if (pop().value == 0) token += token->Oprt.offset;
        break;
      case mu::cmELSE:
        token += token->Oprt.offset;
        break;
      case mu::cmENDIF:
        break;
      case mu::cmFUNC: {
        const std::string name = name_of(parser, *token);
        if (token->Fun.argc == 1) {
          const DualValue x = pop();
          stack.push_back(call_one(name, *token, x));
          break;
        }
        const int count = std::abs(token->Fun.argc);
        assert(count > 0 && count <= static_cast<int>(stack.size()));
        const DualValue y =
            call_many(name, &stack[stack.size() - static_cast<std::size_t>(count)], count);
        stack.resize(stack.size() - static_cast<std::size_t>(count));
        stack.push_back(y);
        break;
      }
      default: {
        const DualValue b = pop(), a = pop();
        stack.push_back(binary(token->Cmd, a, b));
      }
    }
  }
  assert(stack.size() == 1);
  return stack.back();
}

}  // namespace flexopt
