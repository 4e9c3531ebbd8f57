#pragma once
// Whether modal derivatives of vibration modes take the change of inertia into account.

namespace flexopt {

/// Whether they keep their inertia: equation 3 of the paper that core/reduction/modal follows, or
/// equation 4, which leaves out ω²M and its derivative.
enum class ModalInertia { left_out, kept };

}  // namespace flexopt
