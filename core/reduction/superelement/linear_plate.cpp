#include "core/reduction/superelement/linear_plate.hpp"

namespace flexopt::linear_plate {

Operators<double> operators(const PlateMesh& mesh) {
  const PlateMesh::Membrane& A = mesh.membrane();
  Operators<double> result{mesh.shape().width,
                           mesh.shape().thickness,
                           mesh.shape().poissons_ratio,
                           A.A11,
                           A.A12,
                           A.A33,
                           mesh.y(),
                           {}};
  for (int i = 0; i < mesh.elements_along(); ++i)
    for (int j = 0; j < mesh.elements_across(); ++j) {
      const PlateMesh::Element& e = mesh.element(i, j);
      result.elements.push_back({e.gradient, e.bending, e.mass, e.weight});
    }
  return result;
}

Operators<Dual> operators(const PlateMesh& mesh, const PlateMeshRate& rate) {
  const auto& by = rate.shape;
  const PlateMesh::Membrane& A = mesh.membrane();
  const auto membrane = [&](double PlateMesh::Membrane::*member) {
    return Dual(A.*member,
                Vector3d(by[0].membrane.*member, by[1].membrane.*member, by[2].membrane.*member));
  };
  // a matrix with its rates, of which some may be empty: zero
  const auto dual = [&](const auto& value, auto PlateMeshRate::Shape::*member, std::size_t k,
                        auto& result) {
    for (Eigen::Index a = 0; a < value.size(); ++a) {
      Dual& x = *(result.data() + a);
      x = Dual(*(value.data() + a));
      for (int p = 0; p < 3; ++p)
        if (const auto& rates = by[p].*member; !rates.empty())
          x.derivatives()[p] = *(rates[k].data() + a);
    }
  };
  using Shape = PlateMeshRate::Shape;
  const PlateShape& shape = mesh.shape();
  Operators<Dual> result{Dual(shape.width, 3, 0),
                         Dual(shape.thickness, 3, 1),
                         Dual(shape.poissons_ratio, 3, 2),
                         membrane(&PlateMesh::Membrane::A11),
                         membrane(&PlateMesh::Membrane::A12),
                         membrane(&PlateMesh::Membrane::A33),
                         {},
                         {}};
  for (const double y : mesh.y()) result.y.push_back(Dual(y, Vector3d(y / shape.width, 0, 0)));
  for (int i = 0; i < mesh.elements_along(); ++i)
    for (int j = 0; j < mesh.elements_across(); ++j) {
      const std::size_t k = result.elements.size();
      const PlateMesh::Element& e = mesh.element(i, j);
      auto& element = result.elements.emplace_back();
      dual(e.gradient, &Shape::gradient, k, element.gradient);
      dual(e.bending, &Shape::bending, k, element.bending);
      dual(e.mass, &Shape::mass, k, element.mass);
      dual(e.weight, &Shape::weight, k, element.weight);
    }
  return result;
}

}  // namespace flexopt::linear_plate
