#include "optim/job/job_numbers.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <functional>

#include "core/spec/spec_error.hpp"

#include "core/math/decompositions.hpp"

namespace flexopt {
namespace {

constexpr double most = 1e12;  // SI, as the job's own sections have it

/// One number: what it is, and its places in material or end-effector (an inertia off the diagonal
/// has two).
struct Place {
  Parameter parameter;
  std::function<std::vector<double*>(Material&, EndEffector&)> at;
};

std::vector<Place> make_places() {
  std::vector<Place> places;
  const auto add = [&](Parameter parameter, auto at) {
    places.push_back({std::move(parameter), std::move(at)});
  };
  using Where = std::vector<double*>;
  add({"material.youngs_modulus", "Pa", {}, 0, 10 * most, true, false, "Young's modulus"},
      [](Material& m, EndEffector&) { return Where{&m.youngs_modulus}; });
  add({"material.poissons_ratio", "1", {}, -1, 0.5, true, false, "Poisson's ratio"},
      [](Material& m, EndEffector&) { return Where{&m.poissons_ratio}; });
  add({"material.density", "kg/m^3", {}, 0, 1e5, true, false, "density"},
      [](Material& m, EndEffector&) { return Where{&m.density}; });
  add({"end_effector.mass", "kg", {}, 0, most, false, false, "mass of the end-effector"},
      [](Material&, EndEffector& e) { return Where{&e.mass}; });
  const std::string axes = "xyz";
  for (int i = 0; i < 3; ++i)
    add({std::string("end_effector.center_of_mass.") + axes[i],
         "m",
         {},
         -1e3,
         1e3,
         false,
         false,
         "its centre of mass, relative to O"},
        [i](Material&, EndEffector& e) { return Where{&e.center_of_mass[i]}; });
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j)
      add({std::string("end_effector.inertia.") + axes[i] + axes[j],
           "kg m^2",
           {},
           i == j ? 0.0 : -most,
           most,
           false,
           false,
           "its inertia about its centre of mass"},
          [i, j](Material&, EndEffector& e) {
            return i == j ? Where{&e.inertia(i, i)} : Where{&e.inertia(i, j), &e.inertia(j, i)};
          });
  return places;
}

const std::vector<Place>& places() {
  static const std::vector<Place> all = make_places();
  return all;
}

}  // namespace

const std::vector<Parameter>& job_numbers() {
  static const std::vector<Parameter> all = [] {
    std::vector<Parameter> list;
    for (const Place& place : places()) list.push_back(place.parameter);
    return list;
  }();
  return all;
}

const Parameter* find_job_number(const std::string& name) {
  const auto found = std::ranges::find(job_numbers(), name, &Parameter::name);
  return found == job_numbers().end() ? nullptr : &*found;
}

const Parameter* find_parameter(const Family& family, const std::string& name) {
  const auto found = std::ranges::find(family.parameters, name, &Parameter::name);
  return found == family.parameters.end() ? find_job_number(name) : &*found;
}

std::vector<Parameter> parameters_of(const Job& job) {
  std::vector<Parameter> all = find_family(job.design.family, "/design/family").parameters;
  const auto add = [&](const std::string& name) {
    if (const Parameter* number = find_job_number(name);
        number && std::ranges::find(all, name, &Parameter::name) == all.end())
      all.push_back(*number);
  };
  if (job.optimise)
    for (const Variable& v : job.optimise->variables) add(v.parameter);
  if (job.compare) {
    for (const SampleRange& range : job.compare->samples.ranges) add(range.name);
    for (const SampleFormula& formula : job.compare->samples.formulas) add(formula.parameter);
    for (const ParameterValues& design : job.compare->samples.designs)
      for (const auto& [name, value] : design) add(name);
  }
  return all;
}

std::optional<std::string> without_number(const Family& family, const FamilyChoices& choices,
                                          const std::string& name) {
  if (!name.starts_with("end_effector.") || family.has_end_effector(choices)) return std::nullopt;
  return "O is a material point of a leaf here: it has no end-effector";
}

ParameterValues numbers_of(const Material& material, const EndEffector& end_effector) {
  Material m = material;
  EndEffector e = end_effector;
  ParameterValues values;
  for (const Place& place : places()) values[place.parameter.name] = *place.at(m, e).front();
  return values;
}

void set_number(Material& material, EndEffector& end_effector, const std::string& name,
                double value) {
  for (const Place& place : places())
    if (place.parameter.name == name)
      for (double* number : place.at(material, end_effector)) *number = value;
}

std::pair<Material, EndEffector> numbers_set(const Job& job, const ParameterValues& values) {
  std::pair<Material, EndEffector> set{job.design.material, job.end_effector};
  for (const auto& [name, value] : values) set_number(set.first, set.second, name, value);
  if (set.second.inertia != job.end_effector.inertia) check_inertia(set.second.inertia);
  return set;
}

void check_inertia(const Matrix3d& inertia) {
  const Vector3d principal = symmetric_eigenvalues(inertia);
  const double rounding = 1e-9 * principal.cwiseAbs().maxCoeff();
  const std::string at = "/end_effector/inertia",
                    values = fmt::format("principal values {:g}, {:g}, {:g} kg m^2", principal[0],
                                         principal[1], principal[2]);
  if (principal[0] < -rounding) throw SpecError(at, values, "expected none below zero");
  if (principal[2] > principal[0] + principal[1] + rounding)
    throw SpecError(at, values, "no body has these: each is at most the sum of the other two");
}

}  // namespace flexopt
