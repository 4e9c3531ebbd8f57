// Every number of a design file has exact derivatives with respect to every parameter. Checked
// against central differences of the mechanisms themselves, for every family.
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
#include <set>
#include <string>

#include "support/families.hpp"

using namespace flexopt;

TEST_CASE("the derivatives of a family's numbers are those of central differences") {
  const Material& material = materials().front().material;
  for (const Family& family : families()) {
    std::set<std::string> moving, all;  // under some choice
    for (const FamilyChoices& choices : all_choices(family)) {
      INFO(family.name);
      const ParameterValues values = sample_values(family);
      const auto at = [&](const std::string& name, double x) {
        ParameterValues moved = values;
        moved.at(name) = x;
        return numbers_of(family.make(moved, choices, material, some_payload(), values));
      };
      std::vector<std::string> names;
      for (const Parameter& p : family.parameters)
        if (std::ranges::find(family.counts, p.name) == family.counts.end())
          names.push_back(p.name);
      for (const MechanismDirection& d :
           family.directions(values, choices, material, some_payload(), names)) {
        INFO(d.parameter);
        const double x = values.at(d.parameter), h = 1e-5 * (x == 0 ? 1 : std::abs(x));
        const std::vector<double> rate = numbers_of(d.rate);
        // a parameter at its bound, such as a mass of zero, moves inwards only
        const std::vector<double> here = at(d.parameter, x), up = at(d.parameter, x + h),
                                  down = x == 0 ? here : at(d.parameter, x - h);
        REQUIRE(rate.size() == up.size());
        double largest = 0;
        for (std::size_t i = 0; i < rate.size(); ++i) {
          const double known = (std::abs(up[i]) + std::abs(here[i])) * 1e-16 / h;
          CHECK(rate[i] == Approx((up[i] - down[i]) / (x == 0 ? h : 2 * h))
                               .epsilon(x == 0 ? 1e-4 : 1e-6)
                               .margin(2e-8 + 10 * known));
          largest = std::max(largest, std::abs(rate[i]));
        }
        all.insert(d.parameter);
        if (largest > 1e-6) moving.insert(d.parameter);
      }
    }
    CHECK(moving == all);  // every one moves something
  }
}

TEST_CASE("a direction of material or payload moves that number alone") {
  const Family& family = find_family("parallel_guide", "");
  const auto rate = [&](const std::string& name) {
    return family
        .directions(sample_values(family), default_choices(family), materials().front().material,
                    some_payload(), {name})
        .front()
        .rate;
  };
  const auto sum = [](const Mechanism& of) {
    const std::vector<double> all = numbers_of(of);
    return std::accumulate(all.begin(), all.end(), 0.0);
  };
  const Mechanism density = rate("material.density");
  CHECK(density.leaves[0].material.density == 1);
  CHECK(density.leaves[1].material.density == 1);
  CHECK(sum(density) == 2);
  const Mechanism inertia = rate("end_effector.inertia.xy");
  CHECK(inertia.bodies[0].inertia(0, 1) == 1);
  CHECK(inertia.bodies[0].inertia(1, 0) == 1);
  CHECK(sum(inertia) == 2);
  CHECK(sum(rate("end_effector.mass")) == 1);
  CHECK(rate("end_effector.center_of_mass.z").bodies[0].center_of_mass[2] == 1);
  CHECK_THROWS_AS(rate("end_effector.weight"), std::invalid_argument);
}

TEST_CASE("a parameter of one leaf moves that leaf alone, all pieces of a reinforced one") {
  const Material& material = materials().front().material;
  for (const std::string name : {"parallel_guide", "reinforced_guide"}) {
    INFO(name);
    const Family& family = find_family(name, "");
    const FamilyChoices choices = default_choices(family);
    ParameterValues values = sample_values(family);
    values["thickness of leaf -y"] = 2e-6;  // derivatives there are those of leaves that differ
    const auto make = [&](const std::string& along, double by) {
      ParameterValues moved = values;
      moved[along] += by;
      return family.make(moved, choices, material, some_payload());
    };
    const Mechanism here = make("length", 0);
    for (const std::string parameter : {"thickness", "length", "material.youngs_modulus"}) {
      CHECK(family.leaves_along(values, choices, material, parameter) ==
            std::vector<std::string>{"leaf +y", "leaf -y"});
      const std::string along = name_of_one_leaf(parameter, "leaf +y");
      INFO(along);
      const double h = parameter.starts_with("material") ? 1e6 : 1e-7;
      const std::vector<double>
          up = numbers_of(make(along, h)),
          down = numbers_of(make(along, -h)),
          rate = numbers_of(
              family.directions(values, choices, material, some_payload(), {along}).front().rate);
      for (std::size_t i = 0; i < rate.size(); ++i)
        CHECK(rate[i] == Approx((up[i] - down[i]) / (2 * h)).epsilon(1e-6).margin(1e-7));
      Mechanism moved = make(along, h);
      for (std::size_t i = 0; i < here.leaves.size(); ++i) {
        const bool own = here.leaves[i].name.starts_with("leaf +y");
        Mechanism before, after;
        before.leaves = {here.leaves[i]}, after.leaves = {moved.leaves[i]};
        CHECK((numbers_of(before) == numbers_of(after)) == !own);
      }
      moved.leaves = here.leaves;
      CHECK(numbers_of(moved) == numbers_of(here));  // bodies stay
    }
    CHECK(here.leaves.back().thickness == Approx(values.at("thickness") + 2e-6).epsilon(1e-12));
    CHECK(family.leaves_along(values, choices, material, "end_effector.mass").empty());
    CHECK_THROWS_AS(
        family.directions(values, choices, material, some_payload(), {"thickness of leaf +x"}),
        std::invalid_argument);
  }
}

TEST_CASE("along a parameter of all leaves each changes as it does with its own deviation") {
  const Family& family = find_family("parallel_guide", "");
  ParameterValues values = sample_values(family);
  values["thickness of leaf -y"] = 2e-6;
  const auto at = [&](double by) {
    ParameterValues moved = values;
    moved["spacing"] += by;
    return numbers_of(
        family.make(moved, default_choices(family), materials().front().material, some_payload()));
  };
  const std::vector<double> rate =
      numbers_of(family
                     .directions(values, default_choices(family), materials().front().material,
                                 some_payload(), {"spacing"})
                     .front()
                     .rate);
  const std::vector<double> up = at(1e-6), down = at(-1e-6);
  for (std::size_t i = 0; i < rate.size(); ++i)
    CHECK(rate[i] == Approx((up[i] - down[i]) / 2e-6).epsilon(1e-6).margin(1e-7));
}
