#pragma once
// How near errors of assembly are to those that buckle a leaf.
#include "core/mechanism/load_case.hpp"

namespace flexopt {

/// Errors of assembly beside those that buckle a leaf which takes them alone, the sum of all: a
/// turn in its plane beside 2π √(2/(1 + ν)) (t/w)², where M = 2π √(EI GJ)/L; a move across beside a
/// sixth of that times L; a move along beside π² t²/3L, Euler's.
double misassembly(const Mechanism& mechanism, const LoadCase& loads);

}  // namespace flexopt
