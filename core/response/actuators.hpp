#pragma once
// What the actuators of the drives do at a point: voice coils and piezo stacks. Equations (S39) to
// (S41) of README.md.
#include "core/response/quantities.hpp"

namespace flexopt {

/// Whether a drive has an actuator.
bool has_actuators(const Mechanism& mechanism);

/// Sets PathPoint::voice_coil and PathPoint::piezo from the loads and stiffnesses of the drives and
/// the motions of the end-effector by unit strokes (6 × drives). A point of a load path has none.
void set_actuators(const Mechanism& mechanism, const MatrixXd& motions, PathPoint& point);

/// Sets their derivatives from those of the drive loads, and of the amplification where the
/// gradients have the stiffnesses and gains of the drives.
void set_actuator_gradients(const Mechanism& mechanism, const std::vector<Mechanism>& directions,
                            const MatrixXd& motions, const PathPoint& point,
                            PointGradients& gradients);

/// Their rows of the table of quantities.
std::vector<QuantityRow> actuator_rows();

}  // namespace flexopt
