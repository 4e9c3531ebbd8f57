#include "core/reduction/tube/tube_rates.hpp"

#include <cassert>

namespace flexopt {

TubeRates::TubeRates(const TubePotential& potential, const TubeNodeRates& rates)
    : potential_(&potential) {
  for (const std::vector<TubeNode>& nodes : rates) {
    assert(nodes.size() == potential.nodes().size());
    by_shape_.emplace_back(potential.ray(), potential.force_scale(), potential.degree(), nodes,
                           potential.force_centre(), potential.mirrored());
  }
}

auto TubeRates::evaluate(const Vector3d& s, const Vector3d& f) const -> Answer {
  const PotentialValue none{0, Vector6d::Zero(), Matrix6d::Zero()};
  Answer answer{potential_->evaluate(s, f), potential_->third(s, f), {none, none, none}};
  for (std::size_t p = 0; p < by_shape_.size(); ++p)
    answer.by_shape[p] = by_shape_[p].evaluate(s, f);
  return answer;
}

}  // namespace flexopt
