#pragma once
// The box of errors of assembly that a job states, by coordinates z, each −1 … 1.
#include <vector>

#include "core/response/stroke_gradients.hpp"
#include "optim/job/job.hpp"

namespace flexopt {

class AssemblyBox {
 public:
  explicit AssemblyBox(const AssemblyTolerances& spec);

  /// How many errors may differ from zero.
  int size() const { return static_cast<int>(entries_.size()); }
  /// Assembly errors at z: one for each edge that has some.
  std::vector<AssemblyError> errors(const VectorXd& z) const;
  /// The request with the errors at z in addition to its own.
  StrokeRequest misassembled(StrokeRequest request, const VectorXd& z) const;
  /// Directions along every coordinate of the box, for derivatives.
  std::vector<MechanismDirection> directions(const Mechanism& mechanism) const;

 private:
  struct Entry {
    int leaf, end, axis;
    bool turn;
    double size;
  };
  std::vector<Entry> entries_;
};

}  // namespace flexopt
