#pragma once
// Reduced or full leaves, and their mesh, chosen so that errors stay below a tolerance.
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "core/response/path/error_estimate.hpp"

namespace flexopt {

/// The largest mesh that is tried.
inline constexpr std::array<int, 2> largest_mesh{40, 16};
/// What a choice may cost: so many evaluations of all requests by full leaves on the model's mesh.
/// A mesh of n × m elements costs n (m + 1)² of them (n of beams), a reduced path as much as a full
/// one.
inline constexpr double largest_cost = 40;

struct TriedModel {
  Accuracy accuracy = Accuracy::reduced;
  std::array<int, 2> mesh{};
  LargestError largest;  ///< of all numbers but stresses; `path`: of which request
  std::string message;   ///< why it has no estimates; empty otherwise
};

/// Which model was chosen, and why.
struct ChosenModel {
  ModelOptions model;
  bool met = false;  ///< the estimates are below the tolerance
  double cost = 0;   ///< of the choice, as largest_cost
  /// For every request, the paths of full leaves on the chosen mesh, as errors_of needs them.
  std::vector<FullPaths> full;
  std::vector<TriedModel> tried;  ///< in their order, the chosen one last
  std::string message;            ///< one sentence with the figures
};

/// Begins with the model's own mesh. Where the largest error comes from too few elements along or
/// across, there are as many more the next time, twice at most, as an error of second order wants;
/// where it comes from the reduction, full leaves take over. A number that more elements do not
/// bring nearer, or whose error is that of the theory, no longer asks for more of them. All
/// requests, as load cases are, must meet the tolerance; stresses need not. Where some number does
/// not, or where the next mesh would cost more than largest_cost, the last model is the answer and
/// `met` is false. `told` hears of every model when it was tried.
ChosenModel choose_model(const Mechanism& mechanism, const ModelOptions& model,
                         const std::vector<StrokeRequest>& requests, double tolerance,
                         const std::function<void(const TriedModel&)>& told = {});

/// A share in percent with two digits: "0.21 %", "170 %".
std::string percent(double share);

/// "reduced leaves on 14 x 6 elements".
std::string words_for(Accuracy accuracy, const std::array<int, 2>& mesh);

}  // namespace flexopt
