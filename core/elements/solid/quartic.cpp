#include "core/elements/solid/quartic.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/elements/solid/solid_condensation.hpp"
#include "core/elements/solid/solid_element.hpp"
#include "core/math/rotation.hpp"

namespace flexopt {
namespace {

/// A matrix and, where it is asked for, its rate along a change of the body.
using Rated = std::vector<MatrixXd>;

/// Calls add(s, u, s + u) for all terms of a product of such matrices: orders of its two factors
/// and of the term.
template <class Add>
void for_each_term(std::size_t orders, const Add& add) {
  for (std::size_t s = 0; s < orders; ++s)
    for (std::size_t u = 0; s + u < orders; ++u) add(s, u, s + u);
}

/// aᵀ b.
Rated inner_products(const Rated& a, const Rated& b) {
  Rated c(a.size(), MatrixXd::Zero(a[0].cols(), b[0].cols()));
  for_each_term(a.size(), [&](std::size_t s, std::size_t u, std::size_t both) {
    c[both].noalias() += a[s].transpose() * b[u];
  });
  return c;
}

int pairs_of(int m) { return m * (m + 1) / 2; }
int pair_index(int i, int j) { return i >= j ? pairs_of(i) + j : pairs_of(j) + i; }

/// s_ij: displacements of the nodes of patches of second order in the turns of their interfaces.
/// They are linear in the places of nodes and interfaces, whose rates may stand in `places`.
MatrixXd second_turns(const ElasticBody& body, const ElasticBody& places, const MatrixXd& basis) {
  const auto m = static_cast<int>(basis.cols());
  MatrixXd turns = MatrixXd::Zero(3 * static_cast<Eigen::Index>(body.nodes.size()), pairs_of(m));
  for (std::size_t a = 0; a < body.interfaces.size(); ++a)
    for (int i = 0; i < m; ++i)
      for (int j = 0; j <= i; ++j) {
        const auto row = 6 * static_cast<Eigen::Index>(a) + 3;
        const Matrix3d x = hat(basis.block<3, 1>(row, i)), y = hat(basis.block<3, 1>(row, j));
        const Matrix3d second = 0.5 * (x * y + y * x);
        for (const int node : body.interfaces[a].patch)
          turns.block<3, 1>(3 * node, pair_index(i, j)) =
              second * (places.nodes[static_cast<std::size_t>(node)] - places.interfaces[a].origin);
      }
  return turns;
}

/// w a + v b.
ElasticLaw combined(ElasticLaw a, double w, const ElasticLaw& b, double v) {
  a.lambda = w * a.lambda + v * b.lambda;
  a.mu = w * a.mu + v * b.mu;
  return a;
}

/// A symmetric tensor as a column: scalar products of columns are double contractions.
Vector6d tensor_column(const Matrix3d& t) {
  const double r = std::sqrt(2.0);
  Vector6d column;
  column << t.diagonal(), r * t(1, 2), r * t(0, 2), r * t(0, 1);
  return column;
}

/// Integrals over a body whose displacements are Σ U_i e_i + ½ Σ Θ_ij e_i e_j, and their rates
/// along a direction where the fields come with rates.
class SecondOrder {
 public:
  SecondOrder(const ElasticBody& body, const ElasticBody& direction, const Rated& U,
              const Rated& Theta);

  Rated linear;    ///< K U_i: forces at the nodes of first order
  Rated forces;    ///< F2_ij + K Θ_ij: of second order
  Rated energies;  ///< ∫ q_ij:C:q_kl − ε(Θ_ij):C:ε(Θ_kl)

 private:
  struct Point {
    std::vector<ElasticLaw> law;  ///< times the weight of integration
    std::vector<CellPlaces> gradients;
  };

  void add_cell(SolidCell cell, std::span<const int> nodes);
  void add_point(const Point& point);
  void add_pair(const Point& point, int i, int j);
  Eigen::Block<MatrixXd, 3, 3> of_field(Rated& rows, std::size_t order, int f) {
    return rows[order].block<3, 3>(3 * f, 0);
  }

  const ElasticBody *body_, *direction_;
  std::size_t orders_;
  int m_, pairs_;
  Rated fields_, all_forces_;  // U before Θ
  // A cell has displacements of its nodes and forces on them; a point has gradients, and stresses
  // times the weight. Three rows a field.
  Rated local_, local_forces_, slopes_, stresses_;
  // A point has q and ε(Θ), a column a pair, and C of them times the weight.
  Rated q_, Cq_, turned_, Cturned_;
};

SecondOrder::SecondOrder(const ElasticBody& body, const ElasticBody& direction, const Rated& U,
                         const Rated& Theta)
    : energies(U.size(), MatrixXd::Zero(Theta[0].cols(), Theta[0].cols())),
      body_(&body),
      direction_(&direction),
      orders_(U.size()),
      m_(static_cast<int>(U[0].cols())),
      pairs_(static_cast<int>(Theta[0].cols())),
      fields_(orders_, MatrixXd(U[0].rows(), m_ + pairs_)),
      all_forces_(orders_, MatrixXd::Zero(U[0].rows(), m_ + pairs_)),
      local_(orders_),
      slopes_(orders_, MatrixXd(3 * (m_ + pairs_), 3)),
      stresses_(slopes_) {
  for (std::size_t t = 0; t < orders_; ++t) fields_[t] << U[t], Theta[t];
  for (Rated* tensors : {&q_, &Cq_, &turned_, &Cturned_})
    tensors->assign(orders_, MatrixXd(6, pairs_));
  for_each_cell(*body.cells,
                [&](SolidCell cell, std::span<const int> nodes) { add_cell(cell, nodes); });
  for (const MatrixXd& of_all : all_forces_) {
    linear.emplace_back(of_all.leftCols(m_));
    forces.emplace_back(of_all.rightCols(pairs_));
  }
}

void SecondOrder::add_cell(SolidCell cell, std::span<const int> nodes) {
  const CellPlaces places = places_of(body_->nodes, nodes);
  const ElasticLaw law(body_->material);
  for (std::size_t t = 0; t < orders_; ++t) gather_fields(fields_[t], nodes, local_[t]);
  local_forces_.assign(orders_, MatrixXd::Zero(local_[0].rows(), local_[0].cols()));
  for (const ReferencePoint& at : reference_points(cell, SolidRule::energy)) {
    const SolidPoint value = solid_point(at, places);
    Point point{{combined(law, value.weight, law, 0)}, {value.gradients}};
    if (orders_ > 1) {
      const SolidPoint rate = point_rate(value, places_of(direction_->nodes, nodes));
      point.law.push_back(combined(ElasticLaw(body_->material, direction_->material), value.weight,
                                   law, rate.weight));
      point.gradients.push_back(rate.gradients);
    }
    add_point(point);
  }
  for (std::size_t t = 0; t < orders_; ++t) scatter_fields(local_forces_[t], nodes, all_forces_[t]);
}

void SecondOrder::add_point(const Point& point) {
  for (Rated* sums : {&slopes_, &stresses_, &q_, &Cq_, &turned_, &Cturned_})
    for (MatrixXd& sum : *sums) sum.setZero();
  for_each_term(orders_, [&](std::size_t s, std::size_t u, std::size_t both) {
    slopes_[both].noalias() += local_[s] * point.gradients[u].transpose();
  });
  for_each_term(orders_, [&](std::size_t s, std::size_t u, std::size_t both) {
    for (int i = 0; i < m_; ++i)
      of_field(stresses_, both, i) += point.law[s].stress(of_field(slopes_, u, i));
  });
  for (int i = 0; i < m_; ++i)
    for (int j = 0; j <= i; ++j) add_pair(point, i, j);
  for_each_term(orders_, [&](std::size_t s, std::size_t u, std::size_t both) {
    local_forces_[both].noalias() += stresses_[s] * point.gradients[u];
    energies[both].noalias() += q_[s].transpose() * Cq_[u];
    energies[both].noalias() -= turned_[s].transpose() * Cturned_[u];
  });
}

void SecondOrder::add_pair(const Point& point, int i, int j) {
  const int p = pair_index(i, j);
  std::array<Matrix3d, 2> products{Matrix3d::Zero(), Matrix3d::Zero()};  // HᵀH
  for_each_term(orders_, [&](std::size_t s, std::size_t u, std::size_t both) {
    const auto H = of_field(slopes_, s, i), K = of_field(slopes_, s, j);
    products[both] += H.transpose() * of_field(slopes_, u, j);
    of_field(stresses_, both, m_ + p) +=
        H * of_field(stresses_, u, j) + K * of_field(stresses_, u, i);
  });
  for_each_term(orders_, [&](std::size_t s, std::size_t u, std::size_t both) {
    const Matrix3d& H = products[u];
    const Matrix3d theta = of_field(slopes_, u, m_ + p);
    const Matrix3d Cq = point.law[s].stress(H), Cturned = point.law[s].stress(theta);
    of_field(stresses_, both, m_ + p) += Cq + Cturned;
    Cq_[both].col(p) += tensor_column(Cq);
    Cturned_[both].col(p) += tensor_column(Cturned);
    if (s > 0) return;
    q_[u].col(p) = tensor_column(0.5 * (H + H.transpose()));
    turned_[u].col(p) = tensor_column(0.5 * (theta + theta.transpose()));
  });
}

/// A_ijk, a row for each pair i ≥ j, all k.
Rated third_derivatives(const SecondOrder& second, const Rated& U, const Rated& turns) {
  Rated thirds = inner_products(second.forces, U);
  const Rated work = inner_products(second.linear, turns);
  for (std::size_t t = 0; t < thirds.size(); ++t)
    for (int i = 0; i < U[0].cols(); ++i)
      for (int j = 0; j <= i; ++j)
        for (int k = 0; k < U[0].cols(); ++k)
          thirds[t](pair_index(i, j), k) +=
              work[t](i, pair_index(j, k)) + work[t](j, pair_index(i, k));
  return thirds;
}

/// Q of B_ijkl = Q_ij,kl + Q_ik,jl + Q_il,jk. The turns of third order,
///     t_ijk = −⅓ ((θ_i·θ_j) θ_k + (θ_j·θ_k) θ_i + (θ_i·θ_k) θ_j) × r,
/// do work on the forces of first order through the moments of these about each interface.
Rated pair_energies(const SecondOrder& second, const Rated& Theta, const Rated& moments,
                    const MatrixXd& basis) {
  const auto m = static_cast<int>(basis.cols());
  Rated Q = inner_products(second.forces, Theta);
  VectorXd turn(pairs_of(m)), work(pairs_of(m));
  for (std::size_t t = 0; t < Q.size(); ++t) {
    Q[t] += Q[t].transpose().eval() + second.energies[t];
    for (Eigen::Index a = 3; a < basis.rows(); a += 6) {
      const auto theta = basis.middleRows<3>(a);
      const auto moment = moments[t].middleRows<3>(a);
      for (int i = 0; i < m; ++i)
        for (int j = 0; j <= i; ++j) {
          turn[pair_index(i, j)] = theta.col(i).dot(theta.col(j)) / 3;
          work[pair_index(i, j)] =
              theta.col(i).dot(moment.col(j)) + theta.col(j).dot(moment.col(i));
        }
      Q[t] -= turn * work.transpose() + work * turn.transpose();
    }
  }
  return Q;
}

/// All entries of a symmetric array, from those whose indices do not fall.
template <std::size_t degree, class Entry>
std::vector<double> symmetric_array(int m, const Entry& entry) {
  std::vector<double> all(static_cast<std::size_t>(std::lround(std::pow(m, degree))));
  std::array<int, degree> at{};
  while (true) {
    const double value = std::apply(entry, at);
    auto order = at;
    do {
      const auto place = [&](int sum, int i) { return sum * m + i; };
      all[std::accumulate(order.begin(), order.end(), 0, place)] = value;
    } while (std::ranges::next_permutation(order).found);
    const auto last = std::find_if(at.rbegin(), at.rend(), [&](int i) { return i < m - 1; });
    if (last == at.rend()) return all;
    std::fill(last.base() - 1, at.end(), *last + 1);
  }
}

void set_terms(const MatrixXd& thirds, const MatrixXd& Q, ElasticModel& model) {
  const auto m = static_cast<int>(thirds.cols());
  model.cubic =
      symmetric_array<3>(m, [&](int i, int j, int k) { return thirds(pair_index(i, j), k); });
  const auto pair = [&](int i, int j, int k, int l) {
    return Q(pair_index(i, j), pair_index(k, l));
  };
  model.quartic = symmetric_array<4>(m, [&](int i, int j, int k, int l) {
    return pair(i, j, k, l) + pair(i, k, j, l) + pair(i, l, j, k);
  });
}

}  // namespace

MatrixXd elastic_basis(int interfaces) {
  MatrixXd basis = MatrixXd::Zero(6 * interfaces, 6 * interfaces - 6);
  for (int k = 1; k < interfaces; ++k)
    for (int a = 0; a <= k; ++a)
      basis.block<6, 6>(6 * a, 6 * k - 6) =
          (a < k ? 1 : -k) / std::sqrt(k * (k + 1.0)) * Matrix6d::Identity();
  return basis;
}

void add_quartic(const ElasticBody& body, const HeldSolve& solve, CondensedSolid& solid) {
  ElasticModel& model = solid.model;
  model.basis = elastic_basis(model.interfaces());
  const Rated U{solid.fields * model.basis}, turns{second_turns(body, body, model.basis)};
  solid.second_fields = turns[0] - solve(SecondOrder(body, body, U, turns).forces[0]);
  const Rated Theta{solid.second_fields};
  const SecondOrder second(body, body, U, Theta);
  set_terms(
      third_derivatives(second, U, turns)[0],
      pair_energies(second, Theta, inner_products({solid.fields}, second.linear), model.basis)[0],
      model);
}

// A_ijk = Σ_3 ∫ q_ij : C e_k + Σ_3 s_ij · K_fe U_k, (U7) without the fields of second order.
void add_cubic(const ElasticBody& body, const MatrixXd& stiffness_fields, CondensedSolid& solid) {
  ElasticModel& model = solid.model;
  model.basis = elastic_basis(model.interfaces());
  const auto m = static_cast<int>(model.basis.cols());
  const MatrixXd U = solid.fields * model.basis;
  MatrixXd T = second_turns(body, body, model.basis).transpose() * (stiffness_fields * model.basis),
           local, slopes(3 * m, 3), products(6, pairs_of(m)), stresses(6, m);
  const ElasticLaw law(body.material);
  for_each_cell(*body.cells, [&](SolidCell cell, std::span<const int> nodes) {
    const CellPlaces places = places_of(body.nodes, nodes);
    gather_fields(U, nodes, local);
    for (const ReferencePoint& at : reference_points(cell, SolidRule::energy)) {
      const SolidPoint point = solid_point(at, places);
      slopes.noalias() = local * point.gradients.transpose();
      for (int i = 0; i < m; ++i) {
        const Matrix3d H = slopes.middleRows<3>(3 * i);
        stresses.col(i) = tensor_column(point.weight * law.stress(H));
        for (int j = 0; j <= i; ++j) {
          const Matrix3d q = H.transpose() * slopes.middleRows<3>(3 * j);
          products.col(pair_index(i, j)) = tensor_column(0.5 * (q + q.transpose()));
        }
      }
      T.noalias() += products.transpose() * stresses;
    }
  });
  model.cubic = symmetric_array<3>(m, [&](int i, int j, int k) {
    return T(pair_index(i, j), k) + T(pair_index(j, k), i) + T(pair_index(i, k), j);
  });
}

// With F = K_fe U on a patch, the work of F_i on s_jk is θ_jᵀ S_i θ_k, S = sym W − (tr W) 1, W = Σ
// F rᵀ. In the mesh, q_jk : C ε(U_e) is the product of the slopes H_j and H_k σ_e.
MatrixXd cubic_along(const ElasticBody& body, const CondensedSolid& solid, const VectorXd& local) {
  const MatrixXd basis = elastic_basis(static_cast<int>(body.interfaces.size()));
  const VectorXd e = basis.transpose() * local;
  const Eigen::Index m = e.size();
  if (const std::vector<double>& cubic = solid.model.cubic; !cubic.empty())
    return (MatrixXd::Map(cubic.data(), m * m, m) * e).reshaped(m, m);
  if (!body.cells) return {};
  MatrixXd combine(m, m + 1);  // the fields of the basis, and the one along e
  combine << MatrixXd::Identity(m, m), e;
  const MatrixXd U = solid.fields * (basis * combine),
                 F = condensation(body)->stiffness_fields * (basis * combine),
                 theta_of = basis * combine;
  MatrixXd A = MatrixXd::Zero(m, m), local_fields, slopes(3 * (m + 1), 3), q(6, m), stresses(6, m),
           H(9, m), along(9, m);
  for (std::size_t a = 0; a < body.interfaces.size(); ++a) {
    const auto theta = theta_of.middleRows<3>(6 * static_cast<Eigen::Index>(a) + 3);
    MatrixXd turned(3, m);  // S_j θ_e
    Matrix3d S;
    for (Eigen::Index j = 0; j <= m; ++j) {
      Matrix3d W = Matrix3d::Zero();
      for (const int node : body.interfaces[a].patch)
        W += F.block<3, 1>(3 * node, j) *
             (body.nodes[static_cast<std::size_t>(node)] - body.interfaces[a].origin).transpose();
      S = 0.5 * (W + W.transpose()) - W.trace() * Matrix3d::Identity();
      if (j < m) turned.col(j) = S * theta.col(m);
    }
    A += theta.leftCols(m).transpose() * (0.5 * S * theta.leftCols(m) + turned);
  }
  const ElasticLaw law(body.material);
  for_each_cell(*body.cells, [&](SolidCell cell, std::span<const int> nodes) {
    const CellPlaces places = places_of(body.nodes, nodes);
    gather_fields(U, nodes, local_fields);
    for (const ReferencePoint& at : reference_points(cell, SolidRule::energy)) {
      const SolidPoint point = solid_point(at, places);
      slopes.noalias() = local_fields * point.gradients.transpose();
      const Matrix3d of_e = slopes.bottomRows<3>(), stress = point.weight * law.stress(of_e);
      for (Eigen::Index j = 0; j < m; ++j) {
        const Matrix3d own = slopes.middleRows<3>(3 * j), product = own.transpose() * of_e;
        q.col(j) = tensor_column(0.5 * (product + product.transpose()));
        stresses.col(j) = tensor_column(point.weight * law.stress(own));
        H.col(j) = own.reshaped();
        along.col(j) = (own * stress).reshaped();
      }
      A.noalias() += q.transpose() * stresses;
      A.noalias() += 0.5 * H.transpose() * along;
    }
  });
  return A + A.transpose();
}

void add_quartic_rate(const ElasticBody& body, const ElasticBody& direction,
                      const CondensedSolid& solid, const HeldSolve& solve, FieldRates& fields,
                      ElasticModel& rate) {
  const MatrixXd& basis = solid.model.basis;
  const Rated Phi{solid.fields, fields.fields}, U{solid.fields * basis, fields.fields * basis},
      turns{second_turns(body, body, basis), second_turns(body, direction, basis)};
  // inside, the energy is stationary: it needs no rates of the second-order fields there
  const Rated Theta{solid.second_fields, turns[1]};
  const SecondOrder second(body, direction, U, Theta);
  set_terms(third_derivatives(second, U, turns)[1],
            pair_energies(second, Theta, inner_products(Phi, second.linear), basis)[1], rate);
  fields.second_fields = turns[1] - solve(second.forces[1]);
}

}  // namespace flexopt
