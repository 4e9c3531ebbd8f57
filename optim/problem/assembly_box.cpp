#include <fmt/format.h>

#include <algorithm>

#include "optim/problem/misassembled_goals.hpp"

namespace flexopt {

AssemblyBox::AssemblyBox(const AssemblyTolerances& spec) {
  for (const EdgeTolerance& edge : spec.edges)
    for (int k = 0; k < 6; ++k) {
      const double size = k < 3 ? edge.move[k] : edge.turn[k - 3];
      if (size == 0) continue;
      entries_.push_back({edge.leaf, edge.end, k % 3, k >= 3, size});
    }
}

std::vector<AssemblyError> AssemblyBox::errors(const VectorXd& z) const {
  std::vector<AssemblyError> errors;
  for (std::size_t k = 0; k < entries_.size(); ++k) {
    const Entry& e = entries_[k];
    auto own = std::ranges::find_if(
        errors, [&](const AssemblyError& a) { return a.leaf == e.leaf && a.end == e.end; });
    if (own == errors.end()) own = errors.insert(errors.end(), {e.leaf, e.end});
    (e.turn ? own->turn : own->move)[e.axis] += e.size * z[static_cast<Eigen::Index>(k)];
  }
  return errors;
}

StrokeRequest AssemblyBox::misassembled(StrokeRequest request, const VectorXd& z) const {
  for (const AssemblyError& error : errors(z)) {
    auto own = std::ranges::find_if(request.loads.assembly, [&](const AssemblyError& a) {
      return a.leaf == error.leaf && a.end == error.end;
    });
    if (own == request.loads.assembly.end()) {
      request.loads.assembly.push_back(error);
    } else {
      own->move += error.move;
      own->turn += error.turn;
    }
  }
  return request;
}

std::vector<MechanismDirection> AssemblyBox::directions(const Mechanism& mechanism) const {
  std::vector<MechanismDirection> all;
  for (const Entry& e : entries_) {
    AssemblyError rate{e.leaf, e.end};
    (e.turn ? rate.turn : rate.move)[e.axis] = e.size;
    all.push_back(
        assembly_direction(fmt::format("error of assembly {}", all.size()), mechanism, rate));
  }
  return all;
}

}  // namespace flexopt
