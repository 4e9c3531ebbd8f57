#include "optim/job/job_numbers.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cassert>

#include "core/mechanism/body_inertia.hpp"
#include "core/mechanism/each_number.hpp"
#include "core/response/quantities.hpp"
#include "core/spec/names.hpp"
#include "core/spec/spec_error.hpp"

namespace flexopt {
namespace {

constexpr double most = 1e12;  // SI, as the job's own sections have it

/// Unit, range and meaning of a number that a visitor of the mechanism names.
Parameter described(const std::string& section, const std::string& name) {
  Parameter p;
  p.name = section + "." + name;
  p.min = 0, p.max = most;
  if (name == "youngs_modulus") {
    p.unit = "Pa", p.meaning = "Young's modulus", p.max = 10 * most, p.open_min = true;
  } else if (name == "poissons_ratio") {
    p.unit = "1", p.meaning = "Poisson's ratio", p.min = -1, p.max = 0.5, p.open_min = true;
  } else if (name == "density") {
    p.unit = "kg/m^3", p.meaning = "density", p.max = 1e5, p.open_min = true;
  } else if (name == "mass") {
    p.unit = "kg", p.meaning = "mass of the end-effector";
  } else if (name.starts_with("center_of_mass")) {
    p.unit = "m", p.meaning = "its centre of mass, relative to O", p.min = -1e3, p.max = 1e3;
  } else {
    assert(name.starts_with("inertia."));
    p.unit = "kg m^2", p.meaning = "its inertia about its centre of mass";
    if (name[name.size() - 1] != name[name.size() - 2]) p.min = -most;
  }
  return p;
}

/// visit(name, number) for all places of numbers, the job's own names.
template <class Material, class EndEffector, class Visit>
void each_place(Material& material, EndEffector& end_effector, const Visit& visit) {
  each_material_number(material, [&](std::string_view name, auto& number) {
    visit("material." + std::string(name), number);
  });
  each_payload_number(end_effector, [&](std::string_view name, auto& number) {
    visit("end_effector." + std::string(name), number);
  });
}

}  // namespace

const std::vector<Parameter>& job_numbers() {
  static const std::vector<Parameter> all = [] {
    std::vector<Parameter> list;
    Material material;
    EndEffector end_effector;
    each_place(material, end_effector, [&](const std::string& name, double) {
      if (std::ranges::find(list, name, &Parameter::name) != list.end()) return;
      const std::size_t point = name.find('.');
      list.push_back(described(name.substr(0, point), name.substr(point + 1)));
    });
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

std::vector<std::string> parameter_names(const Family& family) {
  std::vector<std::string> names = names_in(family.parameters);
  for (const Parameter& p : job_numbers()) names.push_back(p.name);
  return names;
}

std::vector<Parameter> parameters_of(const Job& job) {
  std::vector<Parameter> all = resolve(job.design)->family().parameters;
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

std::vector<FormulaName> formula_names(const std::vector<Parameter>& parameters) {
  std::vector<FormulaName> names;
  for (const Parameter& p : parameters) names.push_back({p.name, p.unit});
  return names;
}

std::vector<FormulaName> formula_names(DriveList drives, const std::vector<NamedFormula>& defined) {
  std::vector<FormulaName> names;
  drives.named_quantities.clear();
  for (const Quantity& q : quantities(drives)) names.push_back({q.name, q.unit});
  for (const NamedFormula& q : defined) names.push_back({q.name, q.formula->unit(), q.formula});
  return names;
}

DriveList drives_of(const Job& job, DriveList drives) {
  drives.numbers = named_numbers(job.request);
  for (const NamedFormula& q : job.quantities)
    drives.named_quantities.emplace_back(q.name, q.formula->unit());
  return drives;
}

Expression goal_formula(const Job& job, const std::string& text, const std::string& pointer) {
  const Family& family = resolve(job.design)->family();
  std::vector<Parameter> all = family.parameters;
  all.insert(all.end(), job_numbers().begin(), job_numbers().end());
  return {text, formula_names(all), pointer,
          formula_names(drives_of(job, family.drives), job.quantities)};
}

ParameterValues complete_numbers(const Job& job, const ParameterValues& parameters) {
  ParameterValues all = complete_parameters(job.design, parameters);
  const auto [material, end_effector] = numbers_set(job, parameters);
  for (const auto& [name, value] : numbers_of(material, end_effector)) all[name] = value;
  return all;
}

Check has_number(const Family& family, const FamilyChoices& choices, const std::string& name) {
  if (!name.starts_with("end_effector.") || family.has_end_effector(choices)) return {};
  return Because("O is a material point of a leaf here: it has no end-effector");
}

ParameterValues numbers_of(const Material& material, const EndEffector& end_effector) {
  ParameterValues values;
  each_place(material, end_effector,
             [&](const std::string& name, double number) { values.emplace(name, number); });
  return values;
}

void set_number(Material& material, EndEffector& end_effector, const std::string& name,
                double value) {
  each_place(material, end_effector, [&](const std::string& number, double& place) {
    if (number == name) place = value;
  });
}

std::pair<Material, EndEffector> numbers_set(const Job& job, const ParameterValues& values) {
  std::pair<Material, EndEffector> set{job.design.material, job.end_effector};
  for (const auto& [name, value] : values) set_number(set.first, set.second, name, value);
  if (set.second.inertia != job.end_effector.inertia) check_inertia(set.second.inertia);
  return set;
}

void check_inertia(const Matrix3d& inertia) {
  if (const auto fault = inertia_fault(inertia))
    throw SpecError("/end_effector/inertia" + fault->place, fault->value, fault->rule);
}

}  // namespace flexopt
