#pragma once
// Designs of ten families, drawn at random.
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "designs/family.hpp"

namespace flexopt {

/// A design and the largest stroke, drawn at random.
struct Drawn {
  std::string family;
  ParameterValues values;
  FamilyChoices choices;
  double stroke = 0, mass = 0;
};

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double between(double low, double high) {
    constexpr double range = 4294967296.0;
    return low + (high - low) * static_cast<double>(engine_()) / range;
  }
  double even_in_logarithm(double low, double high) {
    return std::exp(between(std::log(low), std::log(high)));
  }
  bool coin() { return between(0, 1) < 0.5; }

 private:
  std::mt19937 engine_;
};

using Draw = std::function<Drawn(Random&)>;

/// One for each family.
const std::vector<Draw>& draws();

/// Of steel.
Mechanism mechanism_of(const Drawn& drawn);

}  // namespace flexopt
