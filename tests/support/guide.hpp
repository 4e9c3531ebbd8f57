#pragma once
// A parallel guide in closed form, so that optima are known on paper.
//
//     drive load      F  = 24 E I x / L³ = 2 E w t³ x / L³      (two guided leaves)
//     stress          σ  = 3 E t x / L²
//     longitudinal    Kx = 2 E w t / (L (1 + 12/700 (x/t)²))    (beam constraint model's form)
//     two modes, made to cross: fa = 100 Hz u (1 − 4x) g, fb = 150 Hz / u (1 − 8x) g, a third
//     above, with u = w / 30 mm and g = 1 − ((t − 0.5 mm) / 1 mm)²
#include <Eigen/Dense>  // before AutoDiff, which needs it
#include <unsupported/Eigen/AutoDiff>

#include <atomic>
#include <cmath>
#include <mutex>
#include <nlohmann/json.hpp>

#include "optim/search/optimise.hpp"

namespace flexopt::guide {

inline double support(double E, double w, double t, double L, double x) {
  return 2 * E * w * t / (L * (1 + 12.0 / 700 * x * x / (t * t)));
}

/// Shared by all copies of the evaluator.
struct Calls {
  std::atomic<int> reduced{0}, full{0}, gradients{0};
  std::mutex mutex;
  StrokeRequest last_request;  ///< of a reduced evaluation
};

/// `breaks_at`: no equilibrium beyond this stress. Full accuracy answers 1 % more of everything.
inline StrokeEvaluator evaluator(Calls& calls, double breaks_at = 1e99) {
  return [&calls, breaks_at](const Mechanism& mechanism, const ModelOptions& model,
                             const StrokeRequest& request) {
    const bool full = model.accuracy == Accuracy::full;
    ++(full ? calls.full : calls.reduced);
    if (!full) {
      const std::lock_guard lock(calls.mutex);
      calls.last_request = request;
    }
    const double s = full ? 1.01 : 1.0;
    const LeafSpring& leaf = mechanism.leaves.front();
    const double E = leaf.material.youngs_modulus, w = leaf.width, t = leaf.thickness,
                 L = leaf.length;
    StrokeResponse response;
    for (const double x : request.points) {
      PathPoint p;
      p.stroke = x;
      const double stress = 3 * E * t * x / (L * L);
      if (stress > breaks_at || response.status != Status::ok) {
        p.status =
            response.status == Status::ok ? PointStatus::no_equilibrium : PointStatus::not_reached;
        p.message = "Newton stopped after 25 iterations";
        response.status = Status::no_equilibrium;
        response.path.push_back(p);
        continue;
      }
      p.status = PointStatus::converged;
      p.drive_load = s * 2 * E * w * t * t * t * x / (L * L * L);
      p.support_stiffness[0] = s * support(E, w, t, L, x);
      if (request.outputs.has(Output::stress)) p.max_stress = StressPeak{s * stress};
      if (request.frequencies_of(DriveState::locked) > 0) {
        const double u = w / 0.03, g = s * (1 - std::pow((t - 0.5e-3) / 1e-3, 2));
        std::vector<double> f{100 * u * (1 - 4 * x) * g, 150 / u * (1 - 8 * x) * g, 400.0};
        std::sort(f.begin(), f.end());
        f.resize(static_cast<std::size_t>(std::min(request.frequencies, 3)));
        for (const double value : f) p.modes_locked.push_back({value});
        p.frequencies_locked = f;
        p.parasitic_frequency = f.front();
      }
      response.path.push_back(p);
    }
    return response;
  };
}

/// The same with derivatives by dual numbers on the closed forms: of what stands in response.
/// `offers`: false stands for a model without exact derivatives.
inline StrokeGradientEvaluator gradient_evaluator(Calls& calls, double breaks_at = 1e99,
                                                  bool offers = true) {
  return [&calls, breaks_at, offers, plain = evaluator(calls, breaks_at)](
             const Job& job, const ParameterValues& parameters,
             const std::vector<std::string>& names, const ModelOptions& model,
             const StrokeRequest& request) {
    ++calls.gradients;
    StrokeSensitivity s;
    s.response = plain(make_mechanism(job, parameters), model, request);
    if (!offers || s.response.status != Status::ok) {
      s.message = "none";
      return s;
    }
    using Dual = Eigen::AutoDiffScalar<VectorXd>;
    const auto n = static_cast<Eigen::Index>(names.size());
    const auto dual = [&](const std::string& name) {
      Dual d(parameters.at(name), VectorXd::Zero(n));
      for (std::size_t i = 0; i < names.size(); ++i)
        if (names[i] == name) d.derivatives()[static_cast<Eigen::Index>(i)] = 1;
      return d;
    };
    const double modulus = job.design.material.youngs_modulus;
    const Dual E = parameters.contains("material.youngs_modulus")
                       ? dual("material.youngs_modulus")
                       : Dual(modulus, VectorXd::Zero(n));
    const Dual w = dual("width"), t = dual("thickness"), L = dual("length");
    const double factor = model.accuracy == Accuracy::full ? 1.01 : 1.0;
    s.gradients.emplace();
    s.gradients->parameters = names;
    for (const PathPoint& point : s.response.path) {
      const double x = point.stroke;
      PointGradients g;
      g.drive_load = Dual(factor * 2 * x * E * w * t * t * t / (L * L * L)).derivatives();
      g.support_stiffness[0] =
          Dual(factor * 2 * E * w * t / (L * (1.0 + 12.0 / 700 * x * x / (t * t)))).derivatives();
      if (request.outputs.has(Output::stress))
        g.max_stress = Dual(factor * 3 * x * E * t / (L * L)).derivatives();
      if (request.frequencies_of(DriveState::locked) > 0) {
        const Dual u = w / 0.03, d = (t - 0.5e-3) / 1e-3, of = factor * (1.0 - d * d);
        std::vector<Dual> f{100 * (1 - 4 * x) * u * of, 150 * (1 - 8 * x) * of / u,
                            Dual(400.0, VectorXd::Zero(n))};
        std::sort(f.begin(), f.end(),
                  [](const Dual& a, const Dual& b) { return a.value() < b.value(); });
        g.frequencies_locked.resize(static_cast<Eigen::Index>(point.frequencies_locked.size()), n);
        for (Eigen::Index k = 0; k < g.frequencies_locked.rows(); ++k)
          g.frequencies_locked.row(k) = f[static_cast<std::size_t>(k)].derivatives();
        g.parasitic_frequency = f.front().derivatives();
      }
      s.gradients->path.push_back(std::move(g));
    }
    return s;
  };
}

inline void set_algorithm(nlohmann::json& job, const std::string& name) {
  if (name == "ipopt")
    job["optimise"]["algorithm"] = {{"library", "ipopt"}};
  else
    job["optimise"]["algorithm"] = {{"library", "nlopt"}, {"name", name}};
}

/// Stiffest guide for its drive load in an envelope. The optimum has both active:
/// t = r L with 2 E w r³ x = 7.5 N → r = 0.005, and L + 40 t = 120 mm → L = 100 mm, t = 0.5 mm.
inline nlohmann::json stiff_guide(const std::string& algorithm = "LN_COBYLA") {
  nlohmann::json job = nlohmann::json::parse(R"({
    "flexopt": 1, "name": "stiff guide", "job": "optimise",
    "design": {
      "family": "parallel_guide",
      "parameters": {"length": "60 mm", "width": "30 mm", "thickness": "0.25 mm", "spacing": "60 mm"},
      "material": {"name": "steel", "youngs_modulus": "200 GPa", "poissons_ratio": 0.3, "density": "7800 kg/m^3"}
    },
    "end_effector": {"mass": "0.5 kg", "inertia": ["4e-4 kg m^2", "4e-4 kg m^2", "4e-4 kg m^2"]},
    "stroke": {"from": 0, "to": "5 mm", "points": 3},
    "optimise": {
      "variables": [
        {"parameter": "length", "min": "50 mm", "max": "150 mm"},
        {"parameter": "thickness", "min": "0.2 mm", "max": "1 mm"}
      ],
      "objective": {"maximise": "support_stiffness.ux", "over_stroke": "min"},
      "constraints": [
        {"quantity": "max_stress", "over_stroke": "max", "max": "600 MPa"},
        {"quantity": "drive_load", "over_stroke": "max_abs", "max": "7.5 N"},
        {"expression": "length + 40*thickness", "max": "120 mm"}
      ],
      "starts": 1, "seed": 1, "max_evaluations": 2000
    }
  })");
  set_algorithm(job, algorithm);
  return job;
}

/// Highest parasitic frequency over the stroke: the two modes cross at the optimum, u² = 144 / 98,
/// t = 0.5 mm.
inline nlohmann::json crossing_modes() {
  nlohmann::json job = stiff_guide();
  job["name"] = "crossing modes";
  job["frequencies"] = 3;
  job["design"]["parameters"]["thickness"] = "0.8 mm";
  job["optimise"]["variables"] = nlohmann::json::parse(R"([
    {"parameter": "width", "min": "15 mm", "max": "60 mm"},
    {"parameter": "thickness", "min": "0.2 mm", "max": "1 mm"}])");
  job["optimise"]["objective"] = {{"maximise", "parasitic_frequency"}, {"over_stroke", "min"}};
  job["optimise"]["constraints"] = nlohmann::json::array();
  return job;
}

/// The optimum of such a job, with differences or exact derivatives (see gradient_evaluator).
inline Optimum run(const nlohmann::json& document, Calls& calls, bool exact = false,
                   OptimiseOptions options = {}, double breaks_at = 1e99, bool offers = true) {
  options.evaluators = {evaluator(calls, breaks_at),
                        exact ? gradient_evaluator(calls, breaks_at, offers) : by_differences};
  return optimise(parse_job(document), options);
}

}  // namespace flexopt::guide
