// What beams are off by at notches, against solids.

#include "core/mechanism/profile.hpp"
#include "core/response/path/error_estimate.hpp"
#include "core/response/path/model_choice.hpp"
#include "support/strokes.hpp"

using namespace flexopt;

namespace {

template <class F>
LeafSpring notch(double length, const F& thickness) {
  LeafSpring leaf = models::leaf({-0.5 * length, 0, 0}, {1, 0, 0}, length, 10e-3, thickness(0.5));
  for (const double s : profile_stations())
    leaf.thickness_profile.push_back(thickness(s) / thickness(0.5));
  return leaf;
}

LeafSpring circular(double radius, double thickness) {
  return notch(2 * radius, [=](double s) {
    return thickness + 2 * radius * (1 - std::sqrt(1 - std::pow(2 * s - 1, 2)));
  });
}

LeafSpring parabolic(double length, double thickness, double depth) {
  return notch(length, [=](double s) { return thickness + 8 * depth * std::pow(s - 0.5, 2); });
}

Mechanism of(const LeafSpring& leaf) {
  Mechanism m{.bodies = {models::body({0, 0, 0}, 0.5, 4e-4)}, .leaves = {leaf}};
  return m;
}

}  // namespace

TEST_CASE("what beams are too stiff by at solid notches is below the error that is told") {
  // Plane stress, E = 200 GPa, ν = 0.3, w = 10 mm, rigid ends, 60 x 10 elements of eight nodes
  // (CalculiX), moment [N m/rad] about the middle and force [N/m] along; w = 4 mm for parabolas.
  struct Solid {
    LeafSpring leaf;
    double width, bending, along;
  };
  const Solid solids[] = {{circular(2e-3, 0.1e-3), 10e-3, 0.312508, 1.60227e8},
                          {circular(2e-3, 0.2e-3), 10e-3, 1.7465, 2.40141e8},
                          {circular(2e-3, 0.6e-3), 10e-3, 26.4762, 4.88505e8},
                          {circular(2e-3, 1e-3), 10e-3, 94.502, 7.09646e8},
                          {circular(2e-3, 2e-3), 10e-3, 556.527, 1.24678e9},
                          {parabolic(10e-3, 0.5e-3, 2e-3), 4e-3, 3.89872, 8.82403e7},
                          {parabolic(4e-3, 0.5e-3, 2e-3), 4e-3, 8.72688, 1.9651e8},
                          {parabolic(10e-3, 0.5e-3, 1e-3), 4e-3, 2.8123, 7.13625e7},
                          {parabolic(10e-3, 1e-3, 1e-3), 4e-3, 16.0892, 1.17094e8},
                          {parabolic(10e-3, 2e-3, 2e-3), 4e-3, 122.487, 2.27803e8}};
  for (const Solid& solid : solids) {
    const LeafSpring& leaf = solid.leaf;
    constexpr int samples = 20000;
    double bend = 0, stretch = 0;
    for (int k = 0; k < samples; ++k) {
      const double t = leaf.thickness * profile_at(leaf.thickness_profile, (k + 0.5) / samples);
      bend += 12 / (t * t * t) / samples;
      stretch += 1 / t / samples;
    }
    const double unit = 200e9 * solid.width / leaf.length,
                 bending = unit / bend / solid.bending - 1,
                 along = unit / stretch / solid.along - 1;
    const ProfileError error = profile_error(of(leaf));
    CAPTURE(leaf.length, leaf.thickness, bending, along);
    CHECK(bending <= error.bending);
    CHECK(error.bending <= 1.9 * bending);
    CHECK(along <= error.translation);
    CHECK(error.translation <= 0.75);
  }
}

TEST_CASE("uniform and gently tapered leaves keep the theory's limit") {
  CHECK(profile_error(of(models::leaf({0, 0, 0}, {1, 0, 0}, 0.1, 0.03, 5e-4))).rotation == 0);
  LeafSpring tapered = models::leaf({0, 0, 0}, {1, 0, 0}, 0.1, 0.03, 5e-4);
  tapered.thickness_profile = {1.3, 0.7};
  CHECK(profile_error(of(tapered)).rotation < 1e-4);
}

TEST_CASE("what a narrow plate is off by against a moment in its plane is below what is told") {
  const ModelOptions plate{.accuracy = Accuracy::full},
      beam{.accuracy = Accuracy::full, .flexure = Flexure::beam};
  for (const double ratio : {1.75, 1.9, 2.0, 2.5, 3.0, 4.0}) {
    const Mechanism m = models::single_leaf(0.05, ratio * 5e-4, 5e-4, Direction::ry);
    const auto load = [&](const ModelOptions& model) {
      return test::evaluated(m, model, {.points = {2e-3}}).path[0].drive_load;
    };
    const double off = std::abs(load(plate) / load(beam) - 1), told = narrow_plate_error(m, plate);
    CAPTURE(ratio, off, told);
    CHECK(off <= told);
    if (ratio < 2) CHECK(told <= 1.6 * off);
    CHECK(narrow_plate_error(m, beam) == 0);
  }
  CHECK(narrow_plate_error(of(models::leaf({0, 0, 0}, {1, 0, 0}, 0.1, 0.03, 5e-4)), plate) < 1e-7);
}

TEST_CASE("the choice of a model says where plates are too narrow, and what to take") {
  const Mechanism m = models::single_leaf(0.05, 7.5e-4, 5e-4, Direction::ry);
  const StrokeRequest request{.points = {0.01},
                              .outputs = {Output::equilibrium, Output::stiffness}};
  const ChosenModel chosen = choose_model(m, {}, {request}, 3e-3, {});
  CHECK_FALSE(chosen.met);
  CHECK(chosen.message.find("take beams") != std::string::npos);
  CHECK(
      choose_model(m, {.flexure = Flexure::beam}, {request}, 3e-3, {}).message.find("take beams") ==
      std::string::npos);
}

TEST_CASE("the error of the theory is part of every estimate of a notch and of its sum") {
  Mechanism m = of(parabolic(10e-3, 0.5e-3, 2e-3));
  m.drives = {make_drive(Direction::rz)};
  ModelOptions model{.accuracy = Accuracy::full, .flexure = Flexure::beam};
  StrokeRequest request{.points = {0, 0.02}, .outputs = {Output::equilibrium, Output::stiffness}};
  const StrokeResponse response = test::evaluated(m, model, request);
  const StrokeErrors errors = estimate_errors(m, model, request, response);
  const ProfileError theory = profile_error(m);
  const EstimatedError *drive = errors.find(1, "drive_stiffness"),
                       *support = errors.find(1, "support_stiffness.ux");
  REQUIRE(drive);
  REQUIRE(support);
  CHECK(drive->theory == Approx(theory.bending * drive->scale));
  CHECK(support->theory == Approx(theory.translation * support->scale));
  CHECK(drive->absolute() >= drive->theory + drive->along);
  const auto largest = largest_error({errors}, false);
  REQUIRE(largest);
  CHECK(largest->theory >= theory.bending);
}
