#pragma once
// How the end-effector moves with each drive: gain and cross-coupling. Equation (S34) of README.md.
#include "core/response/quantities.hpp"

namespace flexopt {

/// The coordinate of the end-effector, 0 … 5, that a drive moves most: a displacement of O if the
/// drive slides, a rotation if it turns. `motion`: displacement of O and spin of the end-effector
/// along global axes per unit stroke. Nothing where no such coordinate moves by more than 1e-9.
std::optional<int> output_of(const Drive& drive, const Vector6d& motion);

/// Sets PathPoint::gain and PathPoint::cross_coupling from the motions of unit strokes, the other
/// drives held: 6 × drives.
void set_gain(const Mechanism& mechanism, const MatrixXd& motions, PathPoint& point);

/// Sets their derivatives from those of the motions, drives · 6 × parameters, drive by drive.
void set_gain_gradients(const Mechanism& mechanism, const MatrixXd& motions, const MatrixXd& rates,
                        PointGradients& gradients);

/// Their rows of the table of quantities.
std::vector<QuantityRow> gain_rows();

}  // namespace flexopt
