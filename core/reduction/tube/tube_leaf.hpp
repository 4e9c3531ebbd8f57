#pragma once
// The reduced leaf: a tube potential with the fields to rebuild the full leaf from.
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/elements/leaf/limited_range.hpp"
#include "core/elements/plate/full_leaf.hpp"
#include "core/reduction/expansion/tube_expansion.hpp"
#include "core/reduction/tube/dynamics_form.hpp"
#include "core/reduction/tube/kept_places.hpp"
#include "core/reduction/tube/mixed_condensation.hpp"
#include "core/reduction/tube/plate_pool.hpp"
#include "core/reduction/tube/tube_dynamics.hpp"
#include "core/reduction/tube/tube_stress.hpp"
#include "core/reduction/tube/tube_view.hpp"

namespace flexopt {

/// Largest relative change of the mechanism's stiffness by the highest degree of a leaf's
/// potential, of degree 5 and of degree 7, and how often a leaf is expanded anew about its forces:
/// core/reduction/README.md.
inline constexpr double largest_degree_change = 0.03, largest_change_of_degree_7 = 0.007;
inline constexpr int most_centred = 3;

/// What an atlas knows of a leaf.
struct KnownTube {
  Eigen::Matrix2d directions;  ///< D, its first column the ray
  std::vector<TubeNode> nodes;
  /// Tables of the dynamics about so many of the same bent states as reach a sigma, made when first
  /// wanted. None: of the leaf.
  std::function<std::vector<DynamicsNode>(double sigma, StationsWanted)> dynamics;
  TubeView view;  ///< of the tables
  /// Tables of stress about the bent states that reach a sigma, made when first wanted.
  std::function<std::vector<StateTable>(double sigma)> stress;
  /// P of (A6) where these are over patterns; else null.
  std::shared_ptr<const StrainPatterns> stress_patterns = nullptr;
  /// Derivatives of the expansions, the ray held. None: the leaf has no exact derivatives.
  std::function<TubeNodeRates()> rates = {};
  /// Derivatives of the tables of the dynamics that reach a sigma. None: no exact derivatives.
  std::function<DynamicsRates(double sigma)> dynamics_rates = {};
  /// Derivatives of the tables of stress. None: no exact derivatives.
  std::function<StressRateSource()> stress_rates = {};
};

/// Potential and fields of all leaves of one shape and range. Grows when a leaf bends further.
class TubeModel {
 public:
  /// Solves and expands the bent states; `built()` tells whether all were found. `pool`: of this
  /// mesh, shared with other models; null for one of its own.
  TubeModel(std::shared_ptr<const PlateMesh> mesh, const TubeRange& range,
            std::shared_ptr<PlatePool> pool = nullptr);
  /// Model of a flat leaf of uniform width and thickness from known expansions. Mesh, bent states
  /// and fields are made when fields or a state beyond the last node are asked for.
  TubeModel(const PlateShape& shape, const TubeRange& range, KnownTube tube);
  /// Model of the same leaf along another ray, about other forces or of another order. It starts
  /// with the two bent states next to sigma; others are added as the leaf reaches them.
  TubeModel(TubeModel& other, const TubeRange& range, double sigma);

  bool built() const { return potential_ != nullptr; }
  const TubePotential& potential() const { return *potential_; }
  /// The potential without its highest degree. The difference from potential() tells what the next
  /// degree would change.
  const TubePotential& lower() const { return *lower_; }
  const TubeRange& range() const { return range_; }
  const PlateShape& shape() const { return shape_; }
  /// Mesh of the leaf, made at its first use where nothing had to be solved. Not for several
  /// threads at once.
  const std::shared_ptr<const PlateMesh>& mesh() const;
  /// Poses of both edges, undeflected.
  EdgePoses rest() const;
  /// Whether the potential is made of known expansions.
  bool known() const { return known_.has_value(); }
  /// Whether rates() has an answer: of a known potential that has not been extended.
  bool differentiable() const { return known_ && known_->rates; }
  /// Derivatives of the nodes of potential() by the leaf's shape, made anew each time.
  TubeNodeRates rates() const { return known_->rates(); }
  bool differentiable_dynamics() const {
    return differentiable() && dynamics_ && known_->dynamics_rates;
  }
  /// Derivatives of the tables of dynamics(), made when they are first wanted.
  const DynamicsRates& dynamics_rates();
  bool differentiable_stress() const {
    return differentiable() && stress_known() && known_->stress_rates;
  }
  /// Derivatives of the tables of stress(), made when they are first wanted.
  const StressRateSource& stress_rates();

  /// Adds a bent state at sigma, beyond the others. False if none was found.
  bool extend(double sigma);

  /// The bent state to add for a leaf at sigma, beyond the others.
  double next_state(double sigma) const;
  /// Model that replaces this one at sigma: of this order (2, 3) along this ray about these forces
  /// (N, M1, M2) over their scale. Shared by all leaves that want the same. Null where no bent
  /// states are found.
  std::shared_ptr<TubeModel> successor(int order, const Eigen::Vector2d& ray,
                                       const Vector3d& forces, double sigma);

  /// Unknowns of the leaf in its chord frame (ChordLeaf::unknowns) at s, f (over their scale):
  /// second-order fields, every coefficient joined by two-point Hermite interpolation.
  VectorXd fields(const Vector3d& s, const Vector3d& f);

  /// Tables of the internal dynamics about the same bent states; they grow with these. None where
  /// not has_dynamics().
  void make_dynamics();
  /// Whether leaves of this shape have tables of the dynamics. Leaves with a profile, curved,
  /// folded and very wide leaves and beams have none, nor do meshes that are too coarse.
  static bool has_dynamics(const PlateShape& shape);
  /// Announces that the dynamics of this many more states will be asked for. Makes the tables once
  /// they cost less than condensing the full leaf at each of these states.
  void expect_dynamics(int states);
  const TubeDynamics* dynamics() const { return dynamics_.get(); }
  /// Tables of strains and places about the same bent states, made at their first use; they grow
  /// with these. None for leaves with a profile, curved ones and beams.
  /// Those that are known reach sigma.
  const TubeStress* stress(double sigma = 0);
  bool stress_known() const { return known_ && known_->stress; }
  /// Makes the tables of the dynamics reach sigma, where there are any.
  void reach_dynamics(double sigma, StationsWanted stations);
  /// How the tables of the dynamics see the leaf.
  TubeView view() const { return dynamics_known() ? known_->view : TubeView{}; }
  /// Sees to it that fields and tables of dynamics reach as far as sigma, where they were not
  /// known.
  void cover(double sigma);

  PlatePool& pool();
  /// Answers of the tables at the latest places where they were asked.
  struct KeptAnswers {
    KeptPlaces<TubeStress::Answer> strains;
    KeptPlaces<StressPeak> peaks;  ///< over Young's modulus; without position and leaf
    KeptPlaces<TubeStress::Slopes> strain_slopes;
    KeptPlaces<TubeDynamics::Answer> dynamics;
    KeptPlaces<DynamicsForm> dynamics_forms;
    KeptPlaces<TubeRates::Answer> potential_rates;
  };
  KeptAnswers& kept() { return kept_; }

 private:
  void build();
  /// The ray and the direction across it.
  static Eigen::Matrix2d ray_directions(const Eigen::Vector2d& ray);
  bool dynamics_known() const { return known_ && known_->dynamics; }
  std::vector<double> planned_states() const;  ///< where bent states are to stand, ascending
  int bent_states() const;                     ///< so many carry the fields
  void stand_at(const TubeExpansion& expansion);
  bool add(double sigma);
  void add_dynamics(double sigma);  ///< at the bent state where leaf() stands
  void look_up_dynamics(double sigma, StationsWanted stations);
  void add_stress(const TubeExpansion& expansion);
  ChordLeaf& leaf();
  void make_potentials(const std::vector<TubeNode>& nodes);
  void make_potentials();

  PlateShape shape_;
  mutable std::shared_ptr<const PlateMesh> mesh_;
  TubeRange range_;
  Eigen::Matrix2d directions_;
  std::optional<KnownTube> known_;       ///< without the nodes, which the potentials have
  DynamicsRates known_dynamics_rates_;   ///< of the present tables; empty before they are wanted
  StressRateSource known_stress_rates_;  ///< derivatives of the present tables of stress
  std::shared_ptr<PlatePool> pool_;
  KeptAnswers kept_;                       ///< of the present tables
  std::vector<TubeExpansion> expansions_;  ///< by sigma; of a known potential fields alone
  bool covered_ = false;                   ///< no bent state was found beyond the last of them
  std::unique_ptr<TubePotential> potential_, lower_;
  InternalLoads loads_;  ///< none before they are wanted
  MatrixXd amplitude_units_;
  std::unique_ptr<TubeDynamics> dynamics_;
  std::unique_ptr<TubeStress> stress_;
  std::vector<std::weak_ptr<TubeModel>> successors_;
  int expected_ = 0;  ///< states at which the dynamics are wanted
};

class TubeLeaf final : public LeafElement, public LimitedRange {
 public:
  /// `reason`: why the potential is not of degree 5, where that is so.
  TubeLeaf(const LeafSpring& leaf, std::shared_ptr<TubeModel> model, int index,
           std::string reason = {});

  void move(const EdgePoses& edges, const Vector12d& dq) override;
  const LeafEvaluation& evaluate() override;
  LimitedRange* limited_range() override { return this; }
  LimitedRange::Refinement refine(const Surroundings& surroundings) override;
  std::unique_ptr<LeafElement> full_model(const std::string& reason) override;
  Answer<std::unique_ptr<LeafLinear>> linearise() override;
  Check check_interior(InteriorUse use) override;
  std::unique_ptr<LeafState> save() const override;
  void restore(const LeafState& state) override;
  void expect_dynamics(int states) override { tables_->expect_dynamics(states); }
  LeafDynamics dynamics(DynamicsRequest request) override;
  Check check_rebuilt() const override { return rebuilt_believed_; }
  LeafStress stress() override;
  LeafShape shape() override;
  std::vector<Vector3d> material_points(const std::vector<std::array<double, 2>>& places) override;
  Vector3d material_point(double along, double across) override;
  /// What the highest degree of the potential changes, relative.
  struct DegreeChanges {
    double own = 0;   ///< the leaf's forces, by the nominal stress that they cause
    double held = 0;  ///< stiffness of the mechanism, drives held: (R5)
    double free = 0;  ///< stiffness of the mechanism, drives free
    double load = 0;  ///< drive loads, the largest
  };
  /// Changes by the highest degree for a leaf within a mechanism; after evaluate().
  DegreeChanges changes_in(const EdgeSurroundings& surroundings) const;
  LeafReport report() const override {
    const bool both = !condensed_because_.empty() && !rebuilt_because_.empty();
    const std::string full = condensed_because_ + (both ? "; " : "") + rebuilt_because_;
    return {.model = "tube",
            .reason = full.empty() ? reason_ : full,
            .check = check_,
            .source = model_->known() ? "atlas" : "built",
            .degree = model_->potential().degree(),
            .replaced = !full.empty()};
  }

  const LeafScale& scale() const { return scale_; }
  const std::shared_ptr<TubeModel>& model() const { return model_; }
  const EdgePoses& edges() const { return edges_; }  ///< scaled
  /// State and response of the latest evaluate().
  const MixedState& mixed() const { return state_.mixed; }
  const ReducedResponse& response() const { return response_; }
  /// Place of the state in the tube, and that place as the tables of the dynamics see it.
  TubeDynamics::Place place() const;
  TubeDynamics::Place place_in_tables() const;
  /// Rates of TubeDynamics::Answer::mass, except those of the amplitudes, by scaled increments of
  /// the edges.
  Matrix12d edge_rates() const;
  /// What the tables' answer at this state makes of the leaf, without stations.
  LeafDynamics dynamics_of(const TubeDynamics::Answer& local) const;
  /// Motion of stations by the tables for all these rates, the amplitudes' too: six rows each, axes
  /// of the leaf.
  MatrixXd tabulated_stations() const;
  /// The root of the mass that each of so many rows stands for.
  double station_weight(Eigen::Index rows) const;

 private:
  /// The edges as those of a flat leaf on the chord.
  EdgePoses chord_edges() const;
  /// State of the full leaf rebuilt from the fields, edges at their present poses.
  PlateLeaf::State rebuilt() const;
  /// The full leaf at that state, moved on by one Newton step with the edges held, or by several;
  /// assembled there where its membrane force was off or there were several. Where it is not to be
  /// believed check_rebuilt() says so.
  PlateLeaf& condensed();
  std::vector<MatrixXd> rebuilt_nodal();
  /// What the stress is taken from where it is not from tables: of a leaf that has some, after
  /// the steps of condensed().
  std::vector<MatrixXd> stressed_nodal();
  /// How far the axial force is from that about which the potential is expanded, over the load that
  /// buckles the leaf between held edges.
  double axial_offset() const;
  /// What the highest degree adds to force and stiffness of the deformations.
  struct HighestDegree {
    Vector6d force;
    Matrix6d stiffness;
  };
  HighestDegree highest_degree() const;
  /// What a force beside the leaf's own makes of nominal stress, over the leaf's: s(Δg)/s(g) of
  /// (R21).
  double own_change(const Vector6d& force) const;
  DegreeChanges changes_in(const EdgeSurroundings& surroundings,
                           const HighestDegree& highest) const;
  /// What the highest degree adds to the stiffness along the ray, the one against the drive, over
  /// that of the unloaded flat leaf: (R19). Zero of leaves without dead load, beams and arcs.
  double change_along_ray(const HighestDegree& highest) const;
  /// Why the potential is not believed here; empty where it is.
  struct Doubt {
    std::string reason;
    bool better_potential_helps = true;  ///< else the full leaf has to take over
  };
  Doubt doubt(const Surroundings& surroundings);
  /// Whether the leaf is believed beside the full one, in equilibrium between the same edges.
  Check check_beside_full(const PlateLeaf& plate) const;
  /// Whether a leaf that is indefinite alone is believed, by the full leaf rebuilt at its state.
  Check check_unsound(const EdgeSurroundings& about);
  /// The ray nearly through the present state, where it is far off the model's; else that.
  Eigen::Vector2d turned_ray() const;
  /// The leaf with a better potential, at the same state; null where there is none.
  std::unique_ptr<TubeLeaf> successor(double sigma, const std::string& reason);
  /// Strains from the tables of stress. Null without tables, and where they do not hold;
  /// rebuilt_because_ then says why.
  const StrainField* tabulated_strains();
  /// Position of a stress peak from the tabulated strains.
  Vector3d tabulated_point(double along, double across);
  LeafShape tabulated_shape();
  /// What the tables of the dynamics say at this state. Null without tables, and where they do not
  /// hold; condensed_because_ then says why.
  const TubeDynamics::Answer* tabulated();
  /// Dynamics from the tables. None where they say nothing, and where more modes are wanted than
  /// they have.
  std::optional<LeafDynamics> tabulated_dynamics(const DynamicsRequest& request);

  LeafSpring leaf_;
  int index_;
  std::string reason_;
  int centred_ = 0;  ///< so often expanded anew about its forces
  LeafScale scale_;
  std::shared_ptr<TubeModel> model_;
  /// Whose tables of dynamics and stress are asked: of a successor those of the first model, which
  /// hold under other forces, too.
  std::shared_ptr<TubeModel> tables_;
  EdgePoses edges_;  ///< scaled
  ReducedState state_;
  ReducedResponse response_;
  double check_ = 0;
  std::shared_ptr<const TubeStress::Answer> stress_;  ///< at this state, where it was asked for
  /// Dynamics at this state, where they were asked for; `reason` tells what is doubted.
  std::shared_ptr<const TubeDynamics::Answer> internal_;
  Check rebuilt_believed_;         ///< of condensed() at this state
  std::string rebuilt_because_;    ///< why the last stress was not from tables that exist
  std::string condensed_because_;  ///< why the last dynamics() was not from tables that exist
  std::optional<PlateLeaf::State> full_state_;  ///< rebuilt(), or as condensed() where it was
  std::uint64_t state_number_ = 0;              ///< of the plate in the pool that stands there
  void forget_answers() {
    full_state_.reset();
    state_number_ = 0;
    stress_.reset();
    internal_.reset();
    rebuilt_believed_ = {};
  }
};

}  // namespace flexopt
