// How far an edge of an overconstrained guide may be turned before its leaves buckle sideways.
//   J. P. Meijaard, D. M. Brouwer, J. B. Jonker, Multibody Syst. Dyn. 23 (2010), 77–97: buckling of
//     a parallel leaf spring guidance by a misalignment, beam elements and experiment.
//   M. Nijenhuis, J. P. Meijaard, D. M. Brouwer, "Misalignments in an Overconstrained Flexure
//     Mechanism: A Cross-Hinge Stiffness Investigation" (2019): lateral buckling with restrained
//     warping gives the critical load and the misalignment that is allowed; without it the limit is
//     markedly too low.
// The measured angles, and the dimensions that belong to them, are not in the parts of these papers
// that are open. What is here is their method, worked out below, against the program.
//
//   Each leaf takes half of the turn ψ by a moment in its plane, M = E I_w ψ/2L (the end-effector
//   takes the rest by its rotation about x). With both edges clamped, v = A (1 − cos kx) and
//   θ = B (1 − cos kx), k = 2π/L, satisfy all conditions of E I v″″ + M θ″ = 0 and
//   E Γ θ″″ − GJ θ″ + M v″ = 0:
//       M_c = k √(E I (GJ + E Γ k²)),   ψ_c = 2 M_c L/(E I_w),   Γ = w³t³/144.
//   Without Γ it is 4π √(2/(1 + ν)) (t/w)², whatever the length.
#include "core/elements/plate/beam_section.hpp"
#include "support/strokes.hpp"

using namespace flexopt;

namespace {

double closed_form(double L, double w, double t, const Material& m, bool warping) {
  const double E = m.youngs_modulus, k = 2 * M_PI / L;
  const BeamSection s = beam_section(Section::rectangular, w, t, m.poissons_ratio);
  const double gamma = warping ? w * w * w * t * t * t / 144 : 0;
  const double moment = k * std::sqrt(E * s.I_weak * (m.shear_modulus() * s.J + E * gamma * k * k));
  return 2 * moment * L / (E * t * w * w * w / 12);
}

PathPoint turned(const Mechanism& guide, const ModelOptions& model, double angle) {
  StrokeRequest request{.points = {0},
                        .loads = {.assembly = {{0, 0, Vector3d::Zero(), {0, angle, 0}}}},
                        .outputs = {Output::equilibrium, Output::stiffness}};
  return evaluate_stroke(guide, model, request).path[0];
}

/// Where the tangent with the drive held becomes indefinite.
double critical_turn(const Mechanism& guide, const ModelOptions& model, double expected) {
  double low = 0.5 * expected, high = 1.1 * expected;
  REQUIRE(turned(guide, model, low).stable);
  REQUIRE_FALSE(turned(guide, model, high).stable);
  while (high - low > 1e-4 * expected)
    (turned(guide, model, 0.5 * (low + high)).stable ? low : high) = 0.5 * (low + high);
  return 0.5 * (low + high);
}

}  // namespace

TEST_CASE("a guide is crooked up to the lateral buckling of its leaves with restrained warping",
          "[slow]") {
  const Material m = models::steel();
  const ModelOptions beams{.accuracy = Accuracy::full, .flexure = Flexure::beam, .mesh = {12, 1}};
  ModelOptions plates{.accuracy = Accuracy::full};
  struct Shape {
    double length, width, thickness;
  };
  for (const auto& [L, w, t] : {Shape{0.1, 0.03, 3.7e-4}, Shape{0.08, 0.03, 3.5e-4},
                                Shape{0.1, 0.015, 2e-4}, Shape{0.12, 0.06, 5e-4}}) {
    CAPTURE(L, w, t);
    const Mechanism guide = models::guide(L, w, t, 0.5);
    const double expected = closed_form(L, w, t, m, true);
    const double by_beams = critical_turn(guide, beams, expected),
                 by_plates = critical_turn(guide, plates, expected);
    CAPTURE(expected, by_beams, by_plates, closed_form(L, w, t, m, false));
    CHECK(by_beams == Approx(expected).epsilon(5e-3));
    // clamps hold the leaves' anticlastic bending: up to E/(1 − ν²) in the one stiffness of two
    CHECK(by_plates > 0.995 * expected);
    CHECK(by_plates < 1.05 * expected);
  }
  // what warping is worth: a third of the width's square over that of the length and more
  CHECK(closed_form(0.08, 0.03, 3.5e-4, m, true) > 1.1 * closed_form(0.08, 0.03, 3.5e-4, m, false));
  // the length does not matter without it
  CHECK(closed_form(0.08, 0.03, 3.5e-4, m, false) ==
        Approx(closed_form(0.16, 0.03, 3.5e-4, m, false)).epsilon(1e-12));
}
