#pragma once
// Bodies that another program has reduced, or assembled: a file in JSON ("flexopt_elastic": 1) with
// interfaces, units, stiffness and mass.
#include <memory>
#include <string>
#include <vector>

#include "core/math/answer.hpp"
#include "core/math/types.hpp"
#include "core/mechanism/elastic_body.hpp"
#include "core/spec/spec_error.hpp"

namespace flexopt {

struct ImportedInterface {
  std::string name;
  Vector3d place;                        ///< own axes of the body [m]
  Matrix3d axes = Matrix3d::Identity();  ///< rows: axes of its coordinates in the file
};

/// What the checks measured, for the report.
struct ImportFigures {
  double asymmetry = 0;       ///< largest of stiffness and mass, scaled by their diagonals
  double rigid_residual = 0;  ///< forces of rigid motions, scaled by the diagonal of the stiffness
  double sixth = 0, seventh = 0;         ///< size of these eigenvalues of the scaled stiffness
  double mass = 0;                       ///< [kg]
  Vector3d center_of_mass;               ///< own axes [m]
  Matrix3d inertia;                      ///< about the centre of mass [kg m²]
  std::vector<double> free_frequencies;  ///< of the body that nothing holds [Hz]
};

struct ImportedBody {
  std::string name, source;
  /// Coordinates: displacement and rotation of each interface in turn, own axes of the body, then
  /// modes. Forces of rigid motions are not projected away.
  std::shared_ptr<const ImportedMatrices> matrices;
  std::vector<ImportedInterface> interfaces;
  ImportFigures figures;
};

/// Reads a body and checks it: (1) symmetric and finite, (2) rigid motions without forces, (3) six
/// of them and no more, (4) a mass matrix of the expected mass, centre and inertia, (5) modes
/// uncoupled and of unit mass, free frequencies as expected. Files that it names are beside it.
/// Throws SpecError with file, line and JSON pointer within; of checks with their number, what was
/// found and the limit.
ImportedBody read_elastic_body(const std::string& file);

/// Check 6: an interface of the body lies where the design has it, to 1e-6 of the body's size.
/// `place`: of the edge or point that it carries, own axes of the body [m].
Check check_interface_place(const ImportedBody& body, const std::string& interface_name,
                            const Vector3d& place);

// Parts of the reading.

/// What is wrong with matrices in SI, own axes of the body, that are none of an elastic body.
struct ImportFault {
  std::string key;          ///< of the file that it is about: "stiffness", "mass", "expected/mass"
  std::string value, rule;  ///< what was found; check, its limit and what may be the cause
};

struct ExpectedBody {
  double mass = 0;                       ///< [kg]
  Vector3d center_of_mass;               ///< own axes [m]
  Matrix3d inertia;                      ///< about it [kg m²]
  bool products = false;                 ///< whether products of inertia are told
  std::vector<double> free_frequencies;  ///< lowest ones [Hz]; empty: not told
};

/// Checks 1 to 5. `expected`: null where none was told. All faults that the numbers of earlier
/// checks allow to be seen; `figures` as far as they go.
std::vector<ImportFault> check_imported(const ImportedMatrices& matrices,
                                        const std::vector<ImportedInterface>& interfaces,
                                        const ExpectedBody* expected, ImportFigures& figures);

/// A square matrix of Matrix Market (coordinate or array; real; general or symmetric). Throws
/// SpecError: another size than `n`, what is no such file.
MatrixXd read_matrix_market(const std::string& file, int n);

/// Units of a file in SI.
struct ImportUnits {
  double length = 1, force = 1, mass = 1;  ///< [m], [N], [kg]
};

/// CalculiX's matrices of a whole body (*FREQUENCY, SOLVER=MATRIXSTORAGE) `stem`.sti, .mas and
/// .dof, and its mesh, condensed to rigid patches: nodes of the named sets, which turn about the
/// places of the interfaces. Throws SpecError.
ImportedMatrices condensed_matrix_storage(const std::string& stem, const std::string& mesh,
                                          const ImportUnits& units,
                                          const std::vector<ImportedInterface>& interfaces,
                                          const std::vector<std::string>& sets);

}  // namespace flexopt
