#pragma once
// Design files of random mechanisms: trees and loops of bodies, leaves of all kinds, joints,
// springs, bushings, frames, repeats and parts.
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <string>

#include "designs/family.hpp"

namespace flexopt {

/// Uniform numbers that are the same everywhere.
class RandomNumbers {
 public:
  explicit RandomNumbers(unsigned long long seed) : engine_(seed) {}
  double between(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  int whole(int low, int high) {  ///< both included
    return low + static_cast<int>(engine_() % static_cast<unsigned long long>(high - low + 1));
  }
  bool chance(double p) { return between(0, 1) < p; }
  Vector3d direction();

 private:
  std::mt19937_64 engine_;
};

struct RandomDesign {
  nlohmann::json document;
  std::string folder;     ///< where the files of its parts are
  std::string driven;     ///< body
  std::string direction;  ///< of the drive
  std::shared_ptr<const Family> family;
  ParameterValues values;  ///< the defaults
  int refused = 0;         ///< tries before it that were no sensible mechanisms

  Mechanism make(const ParameterValues& at) const;
  Mechanism make() const { return make(values); }
};

/// The same for the same seed. Files of parts are written into `folder`.
RandomDesign random_design(unsigned long long seed, const std::string& folder);

/// Reads a document as the program would. Throws SpecError.
std::shared_ptr<const Family> read_document(const nlohmann::json& document,
                                            const std::string& folder);
ParameterValues default_values(const Family& family);
/// What the end-effector carries in all of them.
EndEffector random_payload();

/// The document as a part of another one, in a frame, mirrored there or not ("", "x", "y", "z");
/// the drive's direction is that of the frame. Writes the part into the folder.
nlohmann::json wrapped(const RandomDesign& design, const nlohmann::json& frame,
                       const std::string& mirror);

/// The document with every repeated item written out, index for index.
nlohmann::json without_repeats(const nlohmann::json& document);

}  // namespace flexopt
