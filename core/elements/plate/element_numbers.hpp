#pragma once
// The operators of an element, or, with S = Dual1, their derivatives along a direction of the
// shape.
#include "core/elements/plate/beam_section.hpp"
#include "core/elements/plate/plate_mesh.hpp"

namespace flexopt {

/// Width over t of the layer along a free edge in which (E2) takes its energy.
inline constexpr double free_edge_layer = 0.7;

/// Transverse force in an element and what it gives back: equation (E10) of
/// core/elements/README.md. The rows stand against the element's nodal values.
template <class S>
struct PlateShear {
  Eigen::Matrix<S, 16, 1> along;
  Eigen::Matrix<S, 16, 1> rest;  ///< of a curved leaf at rest, in the axes of its middle
  S compliance;                  ///< C: U = −½ C |Q|²
  S per_x;                       ///< over the second moment of the element's area
};

template <class S>
class CurvatureRows;

template <class S>
class ElementNumbers {
 public:
  /// `mesh` must outlive this.
  explicit ElementNumbers(const MeshNumbers<S>& mesh) : mesh_(mesh) {}
  PlateMesh::Element element(int i, int j) const;
  /// Whether transverse shear is part of the energy.
  bool has_shear() const { return mesh_.shape().transverse_shear; }
  PlateShear<S> plate_shear(int i, int j) const;
  PlateShear<S> beam_shear(int i) const;

 private:
  using Row = Eigen::Matrix<S, 16, 1>;
  using Rest = typename MeshNumbers<S>::Rest;
  using Corner = typename MeshNumbers<S>::Corner;
  using Derivatives = MappedDerivatives<Row>;
  void add_plate_bending(PlateMesh::Element& element, CurvatureRows<S>& natural,
                         const PlateShear<S>& shear, int i, int j) const;
  void set_plate_membrane(PlateMesh::Element& element, int i, int j) const;
  void add_beam(PlateMesh::Element& element, CurvatureRows<S>& natural, const PlateShear<S>& shear,
                int i) const;
  /// Derivatives of the shape functions at a place in element (i, j); `place`: coordinate y0
  /// across.
  Derivatives derivatives(int i, double along, const S& place, const HermiteValuesT<S>& X,
                          const HermiteValuesT<S>& Y) const;
  /// r,xx + ν r,yy where the corner of a fold is, at `across` of element j across.
  Row corner_bend(const Corner& corner, int j, double across, const S& hx, const S& hy) const;
  /// U = ½ w |v|² of v = normal n, by the metric to first order, and what stays of it at rest.
  void add_natural(PlateMesh::Element& element, const S& w, const Rest& rest, const Row& Nx,
                   const Row& Ny) const;
  /// The slope of b n in an element of a curved leaf at rest, its moments about the middle being
  /// Σ weight n, by r,x and r,xx − Γ r,x of the middle.
  Row slope_of_natural(int i, const std::array<S, 4>& weight, const Row& along,
                       const Row& bend) const;
  /// What stands against n in (L2) at a place so far from the element's middle.
  Row against(const Row& bend, const PlateShear<S>& shear, const S& from_middle) const;
  void add_shear(PlateMesh::Element& element, const PlateShear<S>& shear) const;
  /// Equation (E2) over D, on the part of the layers of both free edges that lies in the element.
  void add_free_edges(PlateMesh::Element& element, CurvatureRows<S>& natural, int i, int j) const;
  /// Excess of the second moment of the section in the plane of the leaf that the bending energy
  /// causes where the leaf is `at_thickness` thick, over L, and `width_factor` times as wide; over
  /// t w³: equation (E9). t/w counts up to 1/2.
  S excess_of_bending_in_plane(const S& at_thickness, const S& width_factor) const;
  /// What takes back by how much that energy makes the shear in the plane too stiff: ε_s of (E16).
  S excess_of_shear_in_plane(const S& at_thickness, const S& width_factor) const;
  /// Stiffness in the plane of element i along, over that without what the clamps add: (E17).
  S softer_at_clamps(int i, const S& at_thickness, const S& width_factor) const;

  const MeshNumbers<S>& mesh_;
};

/// What a beam takes of its section at the share `at` of the length, over D and L, for membrane
/// points at Gauss points across.
template <class S>
BeamEnergyT<S> beam_energy_at(const MeshNumbers<S>& mesh, const S& at);

/// Difference of r,xx of the deflected surface from that of its sections, at the share `along` of
/// element (i, j) with the nodal values U: equation (E11).
Vector3d section_turn(const PlateMesh& mesh, int i, int j, const Eigen::Matrix<double, 16, 3>& U,
                      double along);
Vector3<Dual1> section_turn(const MeshNumbers<Dual1>& mesh, int i, int j,
                            const Eigen::Matrix<Dual1, 16, 3>& U, double along);

extern template class ElementNumbers<double>;
extern template class ElementNumbers<Dual1>;

}  // namespace flexopt
