#pragma once
// The numbers of a job beside its family's parameters: of the material and of the end-effector,
// by the names that the directions of a mechanism have.
#include <string>
#include <utility>
#include <vector>

#include "core/math/answer.hpp"
#include "optim/job/expression.hpp"
#include "optim/job/job.hpp"

namespace flexopt {

/// `material.youngs_modulus`, `.poissons_ratio` (each at constant other, so that the shear modulus
/// follows), `.density`; `end_effector.mass`, `.center_of_mass.x` …, `.inertia.xx`, `.inertia.xy` …
const std::vector<Parameter>& job_numbers();

/// The number of this name, or null.
const Parameter* find_job_number(const std::string& name);
/// The family's parameter or the number of the job of that name, or null.
const Parameter* find_parameter(const Family& family, const std::string& name);

/// Names of all parameters of the family and of all numbers of a job.
std::vector<std::string> parameter_names(const Family& family);

/// The family's parameters, then those numbers that differ from design to design.
std::vector<Parameter> parameters_of(const Job& job);

/// Names and units of parameters, and of the quantities of a mechanism and those that a job
/// defines, as formulas want them.
std::vector<FormulaName> formula_names(const std::vector<Parameter>& parameters);
std::vector<FormulaName> formula_names(DriveList drives, const std::vector<NamedFormula>& defined);

/// The drives of a mechanism of the job, or of its family, with what the job's request names and
/// the quantities that the job defines.
DriveList drives_of(const Job& job, DriveList drives);

/// A formula of a goal of the job: of parameters, numbers of the job, and quantities.
Expression goal_formula(const Job& job, const std::string& text, const std::string& pointer = "");

/// `parameters` of a design of the job with what its formulas make of them, and all numbers of its
/// material and end-effector: what formulas of goals may use. Throws SpecError.
ParameterValues complete_numbers(const Job& job, const ParameterValues& parameters);

/// Whether a design has such a number: none of an end-effector where nothing rigid hangs on it.
Check has_number(const Family& family, const FamilyChoices& choices, const std::string& name);

/// All numbers with their present values.
ParameterValues numbers_of(const Material& material, const EndEffector& end_effector);

void set_number(Material& material, EndEffector& end_effector, const std::string& name,
                double value);

/// Material and end-effector of the job with the numbers among `values` in their places. Throws
/// SpecError for an inertia that no body has.
std::pair<Material, EndEffector> numbers_set(const Job& job, const ParameterValues& values);

/// Throws SpecError where no body has the end-effector's inertia.
void check_inertia(const Matrix3d& inertia);

}  // namespace flexopt
