#include <cmath>

#include "results/export/ccx_model.hpp"

namespace flexopt {

namespace {

/// Real numbers under *SPRING have a point: what has none is taken for a degree of freedom.
class Ties {
 public:
  Ties(const CcxModel& model, int number, CcxLines& deck)
      : model_(&model), number_(number), deck_(&deck) {}

  void write() && {
    for (const CcxSpring& spring : model_->springs()) write_spring(spring);
    for (const CcxPin& pin : model_->pins()) write_pin(pin);
    for (const CcxBushing& bushing : model_->bushings()) write_bushing(bushing);
    for (std::size_t k = 0; k < model_->masses().size(); ++k) {
      const CcxMass& mass = model_->masses()[k];
      deck_->line("*ELEMENT, TYPE=MASS, ELSET=MASS{}\n{}, {}", k + 1, ++number_, mass.node);
      deck_->line("*MASS, ELSET=MASS{}\n{:.12g}", k + 1, mass.mass);
    }
  }

 private:
  struct Freedom {
    int node = 0, dof = 0;
  };

  void write_spring(const CcxSpring& tie) {
    const Spring& spring = *tie.spring;
    const int set = ++springs_;
    deck_->line("** spring {}", one_line(spring.name));
    deck_->line("*ELEMENT, TYPE=SPRINGA, ELSET=SPRING{}\n{}, {}, {}", set, ++number_, tie.node,
                tie.other);
    const double built = (spring.place - spring.other_place).norm();
    if (built == spring.free_length) {
      deck_->line("*SPRING, ELSET=SPRING{}\n\n{:#.12g}", set, spring.stiffness);
      return;
    }
    // force over the change of length since it was built
    deck_->line("*SPRING, NONLINEAR, ELSET=SPRING{}\n", set);
    for (const double change : {-0.999 * built, 0.0, 100 * built})
      deck_->line("{:#.12g}, {:#.12g}", spring.stiffness * (built + change - spring.free_length),
                  change);
  }

  /// ½ k (u_a − u_b)².
  void write_between(const Freedom& a, const Freedom& b, double stiffness) {
    const int set = ++ties_;
    deck_->line("*ELEMENT, TYPE=SPRING2, ELSET=TIE{}\n{}, {}, {}", set, ++number_, a.node, b.node);
    deck_->line("*SPRING, ELSET=TIE{}\n{}, {}\n{:#.12g}", set, a.dof, b.dof, stiffness);
  }
  /// ½ k u_a².
  void write_single(const Freedom& a, double stiffness) {
    const int set = ++ties_;
    deck_->line("*ELEMENT, TYPE=SPRING1, ELSET=TIE{}\n{}, {}", set, ++number_, a.node);
    deck_->line("*SPRING, ELSET=TIE{}\n{}\n{:#.12g}", set, a.dof, stiffness);
  }

  void write_pin(const CcxPin& pin) {
    double stiffest = 0;
    for (const LeafSpring& leaf : model_->mechanism().leaves)
      stiffest = std::max(stiffest,
                          leaf.material.youngs_modulus * leaf.width * leaf.thickness / leaf.length);
    deck_->line("** a pin of joint {}", one_line(pin.joint->name));
    for (int c = 1; c <= 3; ++c)
      write_between({pin.node, c}, {pin.other, c}, pin_stiffness * stiffest);
  }

  void write_bushing(const CcxBushing& tie) {
    const Matrix6d& K = *tie.spring->matrix;
    std::vector<Freedom> q;
    for (const auto& [place, rotation] :
         {std::pair{tie.node, tie.rotation}, std::pair{tie.other, tie.other_rotation}})
      for (int k = 0; k < 6 && place > 0; ++k)
        q.push_back(k < 3 ? Freedom{place, k + 1} : Freedom{rotation, k - 2});
    deck_->line("** bushing {}", one_line(tie.spring->name));
    const std::size_t n = q.size();
    const double none = 1e-14 * K.cwiseAbs().maxCoeff();
    const auto S = [&](std::size_t i, std::size_t j) {
      return (i / 6 == j / 6 ? 1 : -1) *
             K(static_cast<Eigen::Index>(i % 6), static_cast<Eigen::Index>(j % 6));
    };
    for (std::size_t i = 0; i < n; ++i) {
      double sum = 0;
      for (std::size_t j = 0; j < n; ++j) {
        sum += S(i, j);
        if (j > i && std::abs(S(i, j)) > none) write_between(q[i], q[j], -S(i, j));
      }
      if (std::abs(sum) > none) write_single(q[i], sum);
    }
  }

  const CcxModel* model_;
  int number_;
  CcxLines* deck_;
  int springs_ = 0, ties_ = 0;
};

}  // namespace

void write_ties(const CcxModel& model, int number, CcxLines& deck) {
  Ties(model, number, deck).write();
}

void write_slides(const CcxModel& model, CcxLines& deck) {
  for (const Joint& joint : model.mechanism().joints) {
    if (joint.type != JointType::prismatic) continue;
    const CcxRigid& rigid = *model.rigid_of(model.rigid_of(joint.body) ? joint.body : joint.other);
    deck.line("** joint {}\n*BOUNDARY\n{}, 1, 3, 0.", one_line(joint.name), rigid.rotation);
    int along = 0;  // the others follow: u_c = a_c / a_along u_along
    joint.axis.cwiseAbs().maxCoeff(&along);
    for (int c = 0; c < 3; ++c) {
      if (c == along) continue;
      std::vector<CcxTerm> terms{{rigid.reference, c + 1, 1}};
      if (std::abs(joint.axis[c]) > 1e-12)
        terms.push_back({rigid.reference, along + 1, -joint.axis[c] / joint.axis[along]});
      write_equation(terms, deck);
    }
  }
}

void write_equation(const std::vector<CcxTerm>& terms, CcxLines& deck) {
  std::vector<std::string> lines;
  for (const CcxTerm& term : terms)
    lines.push_back(fmt::format("{}, {}, {:.12g}", term.node, term.dof, term.factor));
  deck.line("*EQUATION\n{}\n{}", lines.size(), fmt::join(lines, ",\n"));
}

std::vector<CcxTerm> terms_along(int node, const Vector3d& axis) {
  std::array<int, 3> order{0, 1, 2};
  std::ranges::sort(order, {}, [&](int c) { return -std::abs(axis[c]); });
  std::vector<CcxTerm> terms;
  for (const int c : order)
    if (std::abs(axis[c]) > 1e-12) terms.push_back({node, c + 1, axis[c]});
  return terms;
}

}  // namespace flexopt
