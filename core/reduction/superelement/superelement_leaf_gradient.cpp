#include "core/reduction/superelement/superelement_leaf_gradient.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/math/rotation.hpp"

namespace flexopt {

ScaledSuperelements::ScaledSuperelements(const SuperelementLeaf& leaf) : leaf_(&leaf) {
  const LeafScale& scale = leaf.scale();
  for (const NodePose& node : leaf.nodes()) {
    const EdgePose scaled = scale.scaled({node.position, node.axes});
    nodes_.push_back({scaled.position, scaled.axes});
  }
  const int k = grid().nodes_per_line();
  std::vector<NodePose> gathered(grid().nodes_per_element());
  for (int row = 0; row < grid().rows(); ++row) models_.push_back(scaled_model(grid(), row));
  own_ = static_cast<int>(model(0).mass.rows()) - model(0).coordinates();
  for (int e = 0; e < grid().elements(); ++e) {
    for (std::size_t a = 0; a < gathered.size(); ++a) {
      const auto [line, node] = grid().node(e, static_cast<int>(a));
      gathered[a] = nodes_[line * k + node];
    }
    Superelement& element = elements_.emplace_back(model(e));
    framed_ = element.evaluate(gathered) && framed_;
    mass_.push_back(element.mass());
  }
}

Answer<LeafLinear> SuperelementLeaf::linearise() {
  auto linear = std::make_unique<ScaledSuperelements>(*this);
  if (!linear->framed()) return {nullptr, "no floating frame of a superelement was found"};
  return {std::move(linear)};
}

Answer<LeafGradient<double>> ScaledSuperelements::gradient(LeafRates&, const LeafRows& rows) const {
  return {std::make_unique<SuperelementLeafGradient>(*this, rows)};
}

void ScaledSuperelements::solve(Eigen::Ref<MatrixXd> b) const {
  const LeafScale& scale = leaf_->scale();
  const Matrix3d& A = scale.axes;
  // K = Sᵀ K_SI S / D with S = (L A, A) a node
  for (int i = 0; i < nodal(); i += 6) {
    b.middleRows<3>(i) = (A * b.middleRows<3>(i) / scale.length).eval();
    b.middleRows<3>(i + 3) = (A * b.middleRows<3>(i + 3)).eval();
  }
  leaf_->solve(b.topRows(nodal()));
  for (int i = 0; i < nodal(); i += 6) {
    b.middleRows<3>(i) = (scale.energy / scale.length * A.transpose() * b.middleRows<3>(i)).eval();
    b.middleRows<3>(i + 3) = (scale.energy * A.transpose() * b.middleRows<3>(i + 3)).eval();
  }
  for (int e = 0; e < grid().elements(); ++e)
    b.middleRows(amplitude(e), own_).array().colwise() /=
        model(e).stiffness.diagonal().tail(own_).array();
}

MatrixXd ScaledSuperelements::static_shapes(const std::vector<int>& columns) const {
  const LeafScale& scale = leaf_->scale();
  const Matrix3d& A = scale.axes;
  const MatrixXd global = leaf_->static_shapes();
  MatrixXd X = MatrixXd::Zero(unknowns(), global.cols());
  for (int i = 0; i < nodal(); i += 3)
    for (int j = 0; j < global.cols(); j += 3) {
      const double unit = (j % 6 == 0 ? scale.length : 1) / (i % 6 == 0 ? scale.length : 1);
      X.block<3, 3>(i, j) = unit * A.transpose() * global.block<3, 3>(i, j) * A;
    }
  return X(Eigen::all, columns);
}

MatrixXd ScaledSuperelements::station_motion(const MatrixXd& V) const {
  const LeafScale& scale = leaf_->scale();
  const double share = std::sqrt(scale.mass * grid().shape().width * 6 / std::max(nodal(), 6)),
               half = 0.5 / grid().along();
  MatrixXd motion = share * V.topRows(nodal());
  for (int i = 3; i < nodal(); i += 6) motion.middleRows<3>(i) *= half;
  for (int i = 0; i < nodal(); i += 3)
    motion.middleRows<3>(i) = (scale.axes * motion.middleRows<3>(i)).eval();
  return motion;
}

MatrixXd ScaledSuperelements::element_rates(int e, const MatrixXd& V) const {
  const LeafScale& scale = leaf_->scale();
  const int m = grid().nodes_per_element(), k = grid().nodes_per_line();
  MatrixXd rates(6 * m + own_, V.cols());
  for (int a = 0; a < m; ++a) {
    const auto [line, node] = grid().node(e, a);
    if (leaf_->is_edge(line)) {
      const Vector3d arm = nodes_[line * k + node].axes.col(1) * grid().y(node) / scale.length;
      rates.middleRows<6>(6 * a) = V.middleRows<6>(unknowns() + 6 * leaf_->edge_of(line));
      rates.middleRows<3>(6 * a) -= hat(arm) * rates.middleRows<3>(6 * a + 3);
    } else {
      rates.middleRows<6>(6 * a) = V.middleRows<6>(leaf_->offset(line) + 6 * node);
    }
  }
  rates.bottomRows(own_) = V.middleRows(amplitude(e), own_);
  return rates;
}

MatrixXd ScaledSuperelements::mass_times(const MatrixXd& V) const {
  assert(V.rows() == unknowns() + 12);
  const LeafScale& scale = leaf_->scale();
  const int m = grid().nodes_per_element(), k = grid().nodes_per_line();
  MatrixXd result = MatrixXd::Zero(V.rows(), V.cols());
  for (int e = 0; e < grid().elements(); ++e) {
    const MatrixXd f = mass_[e] * element_rates(e, V);
    for (int a = 0; a < m; ++a) {
      const auto [line, node] = grid().node(e, a);
      const auto own = f.middleRows<6>(6 * a);
      if (leaf_->is_edge(line)) {
        const Vector3d arm = nodes_[line * k + node].axes.col(1) * grid().y(node) / scale.length;
        const int row = unknowns() + 6 * leaf_->edge_of(line);
        result.middleRows<6>(row) += own;
        result.middleRows<3>(row + 3) += hat(arm) * own.topRows<3>();
      } else {
        result.middleRows<6>(leaf_->offset(line) + 6 * node) += own;
      }
    }
    result.middleRows(amplitude(e), own_) += f.bottomRows(own_);
  }
  return result;
}

SuperelementLeafGradient::SuperelementLeafGradient(const ScaledSuperelements& leaf,
                                                   const LeafRows& rows)
    : LeafGradient<double>(rows, leaf.grid().shape().width), leaf_(&leaf) {
  const SuperelementLeaf& of = leaf.leaf();
  const SuperelementGrid& grid = leaf.grid();
  const int k = grid.nodes_per_line(), count = static_cast<int>(leaf.nodes().size());
  assert(rows.unknowns == leaf.unknowns());
  for (int line = 0; line < grid.lines(); ++line)
    for (int j = 0; j < k; ++j) {
      Node node{-1, 0, Vector3d::Zero(), Vector3d::Zero(), grid.y(j) / of.scale().length};
      if (of.is_edge(line)) {
        const int e = node.edge = of.edge_of(line);
        edge_axes_[e] = leaf.nodes()[line * k + j].axes;
        node.row = rows.body(e);
        node.local = edge_axes_[e].transpose() * rows.lever[e] + node.y * Vector3d::UnitY();
        node.arm = edge_axes_[e] * node.local;
      } else {
        node.row = of.offset(line) + 6 * j;
      }
      nodes_.push_back(node);
    }
  node_force_ = MatrixXd::Zero(6 * count, 1);
  shape_force_ = MatrixXd::Zero(6 * count, 3);
  elements_.reserve(grid.elements());
  for (int e = 0; e < grid.elements(); ++e) {
    elements_.emplace_back(leaf[e], grid.model_rate()[e].shape);
    scatter(e, leaf[e].force(), node_force_);
    scatter(e, elements_[e].force_rates(), shape_force_);
  }
  const SuperelementLeaf::Point point = of.point();
  const LeafScale& scale = of.scale();
  const Vector3d force = scale.axes.transpose() * point.force * (scale.length / scale.energy);
  Vector3d apart =
      scale.axes.transpose() * (point.place + point.displacement - scale.origin) / scale.length;
  for (const NodeShare& s : of.shares()) {
    const int i = s.node.line * k + s.node.node;
    assert(nodes_[i].edge < 0);
    node_force_.block<3, 1>(6 * i, 0) -= s.weight * force;
    apart -= s.weight * leaf.nodes()[i].position;
  }
  MatrixXd all = MatrixXd::Zero(size(), 1);
  add_to_rows(node_force_, all);
  force_ = all;
  if (rows.point > 0) {
    force_.segment<3>(rows.unknowns) = apart;
    force_.segment<3>(rows.point_body()) = force;
  }
}

MatrixXd SuperelementLeafGradient::gather(int element, const MatrixXd& nodal) const {
  const SuperelementGrid& grid = leaf_->grid();
  const int m = grid.nodes_per_element(), k = grid.nodes_per_line();
  MatrixXd own(6 * m, nodal.cols());
  for (int a = 0; a < m; ++a) {
    const auto [line, node] = grid.node(element, a);
    own.middleRows<6>(6 * a) = nodal.middleRows<6>(6 * (line * k + node));
  }
  return own;
}

void SuperelementLeafGradient::scatter(int element, const MatrixXd& own,
                                       Eigen::Ref<MatrixXd> nodal) const {
  const SuperelementGrid& grid = leaf_->grid();
  const int m = grid.nodes_per_element(), k = grid.nodes_per_line();
  for (int a = 0; a < m; ++a) {
    const auto [line, node] = grid.node(element, a);
    nodal.middleRows<6>(6 * (line * k + node)) += own.middleRows<6>(6 * a);
  }
}

bool SuperelementLeafGradient::at_edge(int element) const {
  const SuperelementGrid& grid = leaf_->grid();
  for (int a = 0; a < grid.nodes_per_element(); ++a) {
    const auto [line, node] = grid.node(element, a);
    if (leaf_->leaf().is_edge(line)) return true;
  }
  return false;
}

void SuperelementLeafGradient::add_to_rows(const MatrixXd& nodal, MatrixXd& rows) const {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Node& node = nodes_[i];
    const auto f = nodal.middleRows<6>(6 * static_cast<Eigen::Index>(i));
    rows.middleRows<6>(node.row) += f;
    if (node.edge >= 0) rows.middleRows<3>(node.row + 3) += hat(node.arm) * f.topRows<3>();
  }
}

MatrixXd SuperelementLeafGradient::increments(const MatrixXd& Y) const {
  MatrixXd N(6 * nodes_.size(), Y.cols());
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Node& node = nodes_[i];
    auto rates = N.middleRows<6>(6 * static_cast<Eigen::Index>(i));
    rates = Y.middleRows<6>(node.row);
    if (node.edge >= 0) rates.topRows<3>() -= hat(node.arm) * Y.middleRows<3>(node.row + 3);
  }
  return N;
}

MatrixXd SuperelementLeafGradient::node_rates(
    const std::vector<LeafVariation<double>>& variations) const {
  MatrixXd Z = MatrixXd::Zero(6 * nodes_.size(), static_cast<Eigen::Index>(variations.size()));
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Node& node = nodes_[i];
    if (node.edge < 0) continue;
    const Matrix3d& R = edge_axes_[node.edge];
    for (std::size_t k = 0; k < variations.size(); ++k) {
      const LeafVariation<double>& v = variations[k];
      const LeafVariation<double>::Edge& edge = v.edge[node.edge];
      const Matrix3d spin = edge.rotation * R.transpose();
      Z.block<6, 1>(6 * i, k) << edge.rotation * node.local + edge.position +
                                     R * (edge.arm + v.shape[ShapeParameter::width] / width_ *
                                                         node.y * Vector3d::UnitY()),
          0.5 * Vector3d(spin(2, 1) - spin(1, 2), spin(0, 2) - spin(2, 0), spin(1, 0) - spin(0, 1));
    }
  }
  return Z;
}

MatrixXd SuperelementLeafGradient::force_rates(
    const std::vector<LeafVariation<double>>& variations) const {
  const int columns = static_cast<int>(variations.size());
  const MatrixXd Z = node_rates(variations);
  Eigen::Matrix3Xd shape(3, columns);
  for (int k = 0; k < columns; ++k) {
    assert(variations[k].point.isZero(1e-9));  // the point stays a node
    shape.col(k) = variations[k].shape;
  }
  MatrixXd F = shape_force_ * shape;
  for (std::size_t e = 0; e < elements_.size(); ++e)  // only the edges' nodes move
    if (const int i = static_cast<int>(e); at_edge(i))
      scatter(i, elements_[e].force_rates(gather(i, Z)), F);
  MatrixXd rows = MatrixXd::Zero(size(), columns);
  add_to_rows(F, rows);
  // the edges' arms turn and grow
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    if (nodes_[i].edge < 0) continue;
    const Vector3d f = node_force_.block<3, 1>(6 * i, 0);
    for (int k = 0; k < columns; ++k)
      rows.block<3, 1>(nodes_[i].row + 3, k) +=
          Vector3d(Z.block<3, 1>(6 * i, k) - variations[k].edge[nodes_[i].edge].position).cross(f);
  }
  if (rows_.point == 0) return rows;
  const SuperelementLeaf& leaf = leaf_->leaf();
  const LeafScale& scale = leaf.scale();
  const Vector3d u = scale.axes.transpose() * leaf.point().displacement / scale.length;
  double across = 0;  // of the undeflected point
  for (const NodeShare& s : leaf.shares())
    across += s.weight * nodes_[s.node.line * leaf_->grid().nodes_per_line() + s.node.node].y;
  for (int k = 0; k < columns; ++k) {
    const LeafVariation<double>& v = variations[k];
    rows.block<3, 1>(rows_.unknowns, k) +=
        v.turn * u - v.length * u +
        across * v.shape[ShapeParameter::width] / width_ * Vector3d::UnitY();
  }
  return rows;
}

LeafQuadratic<double> SuperelementLeafGradient::quadratic(const MatrixXd& Y,
                                                          const VectorXd& mu) const {
  const int columns = static_cast<int>(Y.cols()), own = leaf_->own_amplitudes(),
            nodal = 6 * leaf_->grid().nodes_per_element();
  assert(Y.rows() == size() && mu.size() == columns);
  const MatrixXd N1 = increments(Y);
  MatrixXd N2 = MatrixXd::Zero(N1.rows(), columns), n0 = N2, n1 = N2;
  for (std::size_t i = 0; i < nodes_.size(); ++i)
    if (nodes_[i].edge >= 0)
      for (int k = 0; k < columns; ++k) {
        const Vector3d w = Y.block<3, 1>(nodes_[i].row + 3, k);
        N2.block<3, 1>(6 * i, k) = w.cross(w.cross(nodes_[i].arm));
      }
  LeafQuadratic<double> q(size(), columns);
  SuperelementGradient::Quadratic of_element;
  VectorXd y(nodal + own);
  for (std::size_t i = 0; i < elements_.size(); ++i) {
    const int e = static_cast<int>(i);
    const MatrixXd own1 = gather(e, N1);
    MatrixXd state(nodal, columns), increment(nodal, columns);
    for (int k = 0; k < columns; ++k) {
      y << own1.col(k), Y.col(k).segment(leaf_->amplitude(e), own);
      elements_[i].quadratic(y, mu[k], of_element);
      q.stiffness[k] += of_element.stiffness;
      q.mass[k] += of_element.mass;
      q.shape.col(k) += of_element.model;
      state.col(k) = of_element.state;
      increment.col(k) = of_element.increment.head(nodal);
    }
    if (at_edge(e)) {  // f·N2
      const MatrixXd own2 = gather(e, N2);
      state += (*leaf_)[e].tangent() * own2;
      q.shape += elements_[i].force_rates().transpose() * own2;
    }
    scatter(e, state, n0);
    scatter(e, increment, n1);
  }
  q.stiffness += N2.transpose() * node_force_;

  // Nodes of the edges: p + v, u + ω×v, ω×(ω×v) with v = R w
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Node& node = nodes_[i];
    if (node.edge < 0) {
      q.state.middleRows<6>(node.row) += n0.middleRows<6>(6 * static_cast<Eigen::Index>(i));
      continue;
    }
    const Matrix3d& R = edge_axes_[node.edge];
    const Vector3d& v = node.arm;
    const Vector3d f = node_force_.block<3, 1>(6 * i, 0);
    for (int k = 0; k < columns; ++k) {
      LeafQuadratic<double>::Edge& g = q.edge[k][node.edge];
      const Vector3d w = Y.block<3, 1>(node.row + 3, k), fw = f.cross(w),
                     f0 = n0.block<3, 1>(6 * i, k), m0 = n0.block<3, 1>(6 * i + 3, k),
                     f1 = n1.block<3, 1>(6 * i, k), m1 = n1.block<3, 1>(6 * i + 3, k);
      const Vector3d c = f0 + f1.cross(w) + fw.cross(w);
      g.rotation += c * node.local.transpose() + 0.5 * hat(m0) * R;
      g.position += f0;
      g.arm += R.transpose() * c;
      g.across += node.y * R.col(1).dot(c);
      g.displacement += f1;
      g.spin += m1 + v.cross(f1) + w.cross(v).cross(f) + v.cross(fw);
      q.state.block<3, 1>(node.row, k) += f0;
      q.state.block<3, 1>(node.row + 3, k) += v.cross(c) + m0;
    }
  }
  // the point: 2 y_f·(y_u − Σ w N1)
  if (rows_.point > 0)
    for (int k = 0; k < columns; ++k) {
      Vector3d apart = Y.block<3, 1>(rows_.point_body(), k);
      for (const NodeShare& s : leaf_->leaf().shares()) {
        const int i = s.node.line * leaf_->grid().nodes_per_line() + s.node.node;
        apart -= s.weight * N1.block<3, 1>(6 * i, k);
      }
      q.stiffness[k] += 2 * apart.dot(Y.block<3, 1>(rows_.unknowns, k));
    }
  return q;
}

VectorXd SuperelementLeafGradient::field_rate(int e, const MatrixXd& nodes,
                                              const Vector3d& shape) const {
  const Superelement& element = (*leaf_)[e];
  const auto& rates = leaf_->grid().model_rate()[e].shape;
  const VectorXd q = element.local_rate() * gather(e, nodes) + elements_[e].local_rates() * shape;
  VectorXd field = leaf_->model(e).recovery * q;
  for (int p = 0; p < 3; ++p) field += shape[p] * (rates[p].recovery * element.local());
  return field;
}

std::vector<VectorXd> SuperelementLeafGradient::field_rates(
    const VectorXd& y, const LeafVariation<double>& variation) const {
  const MatrixXd nodes = increments(y) + node_rates({variation});
  std::vector<VectorXd> rates;
  for (int e = 0; e < leaf_->grid().elements(); ++e)
    rates.push_back(field_rate(e, nodes, variation.shape));
  return rates;
}

Vector3d SuperelementLeafGradient::place_rate(double along, double across, const VectorXd& y,
                                              const LeafVariation<double>& variation) const {
  const SuperelementGrid& grid = leaf_->grid();
  const SuperelementGrid::Point at = grid.locate(along, across);
  const PlateMesh& mesh = *grid.plate(at.element).mesh;
  const MatrixXd nodes = increments(y) + node_rates({variation});
  const VectorXd field = leaf_->model(at.element).recovery * (*leaf_)[at.element].local(),
                 rate = field_rate(at.element, nodes, variation.shape);
  const double width = mesh.shape().width,
               widening = width * variation.shape[ShapeParameter::width] / width_;
  // seen from the frame, over the superelement's length
  Vector3d place(at.along - 0.5, (at.across - 0.5) * width, 0),
      moves(0, (at.across - 0.5) * widening, 0);
  const int n = mesh.functions_per_line();
  for (const NodalWeight& w : point_weights(mesh, at.along, at.across))
    for (int c = 0; c < 3; ++c) {
      const int dof = 3 * n * w.line + n * c + w.function;
      place[c] += w.weight * field[dof];
      moves[c] += w.weight * rate[dof];
    }
  const ShapeRate own(Vector3d(widening, 0, 0));
  for (const NodalWeight& w : point_weight_rates(mesh, own, at.along, at.across))
    for (int c = 0; c < 3; ++c) moves[c] += w.weight * field[3 * n * w.line + n * c + w.function];
  Vector6d frame = elements_[at.element].frame_rates(gather(at.element, nodes));
  for (int p = 0; p < 3; ++p) frame += variation.shape[p] * elements_[at.element].frame_rate(p);
  const double length = 1.0 / grid.along();
  return (*leaf_)[at.element].frame().axes *
         (frame.head<3>() + length * (frame.tail<3>().cross(place) + moves));
}

namespace {

class SuperelementFields final : public LeafFields {
 public:
  SuperelementFields(const SuperelementLeafGradient& gradient, MatrixXd rows,
                     std::vector<LeafVariation<double>> variations)
      : gradient_(&gradient), rows_(std::move(rows)), variations_(std::move(variations)) {}

  MatrixXd place_rates(double along, double across) const override {
    MatrixXd rates(3, rows_.cols());
    for (int p = 0; p < rates.cols(); ++p)
      rates.col(p) = gradient_->place_rate(along, across, rows_.col(p), variations_[p]);
    return rates;
  }
  VectorXd stress_rates(const StressPeak& peak, double /*modulus*/,
                        const VectorXd& modulus_rates) const override {
    VectorXd stress(rows_.cols());
    for (int p = 0; p < stress.size(); ++p)
      stress[p] =
          gradient_->leaf().stress_rate(peak, gradient_->field_rates(rows_.col(p), variations_[p]),
                                        {{}, Vector3d(variations_[p].shape), modulus_rates[p]});
    return stress;
  }

  MatrixXd section_rates(const std::vector<StressPlace>& places, double /*modulus*/,
                         const VectorXd& modulus_rates) const override {
    MatrixXd rates(6 * static_cast<Eigen::Index>(places.size()), rows_.cols());
    for (Eigen::Index p = 0; p < rates.cols(); ++p) {
      const LeafVariation<double>& v = variations_[static_cast<std::size_t>(p)];
      rates.col(p) =
          gradient_->leaf().section_rates(places, gradient_->field_rates(rows_.col(p), v),
                                          {{}, Vector3d(v.shape), modulus_rates[p]});
    }
    return rates;
  }

 private:
  const SuperelementLeafGradient* gradient_;
  MatrixXd rows_;
  std::vector<LeafVariation<double>> variations_;
};

}  // namespace

std::unique_ptr<LeafFields> SuperelementLeafGradient::fields(
    const MatrixXd& rows, const std::vector<LeafVariation<double>>& variations) const {
  return std::make_unique<SuperelementFields>(*this, rows, variations);
}

}  // namespace flexopt
