#pragma once
// A small job that many tests run: one leaf, bent by 4 mm.
#include <nlohmann/json.hpp>

#include "results/files/json_text.hpp"

namespace flexopt::test {

inline OrderedJson leaf_job() {
  return OrderedJson::parse(R"({
    "flexopt": 1, "name": "leaf", "job": "evaluate",
    "design": {"family": "leaf_spring",
               "parameters": {"length": "80 mm", "width": "20 mm", "thickness": "0.3 mm"},
               "material": {"youngs_modulus": "200 GPa", "poissons_ratio": 0.3,
                            "density": "7800 kg/m^3"}},
    "end_effector": {"mass": "20 g", "inertia": ["2e-6 kg m^2", "2e-6 kg m^2", "2e-6 kg m^2"]},
    "stroke": {"from": 0, "to": "4 mm", "points": 3},
    "model": {"accuracy": "full", "mesh": [4, 2]},
    "frequencies": 3})");
}

/// Its `optimise`: the stiffest leaf that 1 N bends.
inline OrderedJson thickest_leaf() {
  return OrderedJson::parse(R"({
    "variables": [{"parameter": "thickness", "min": "0.2 mm", "max": "0.6 mm"}],
    "objective": {"maximise": "support_stiffness.uz", "over_stroke": "min"},
    "constraints": [{"quantity": "drive_load", "over_stroke": "max_abs", "max": "1 N"}],
    "algorithm": {"library": "nlopt", "name": "LN_COBYLA"}, "starts": 2, "max_evaluations": 40})");
}

inline OrderedJson optimised_leaf() {
  OrderedJson job = leaf_job();
  job["job"] = "optimise";
  job["optimise"] = thickest_leaf();
  return job;
}

/// The leaf at six thicknesses, at full accuracy and on a coarse mesh.
inline OrderedJson compared_leaf() {
  OrderedJson job = leaf_job();
  job["job"] = "compare";
  job.erase("model");
  job["samples"] = OrderedJson::parse(R"({"count": 6, "seed": 3, "vary": [
      {"parameter": "thickness", "min": "0.2 mm", "max": "0.6 mm"}]})");
  job["models"] = OrderedJson::parse(R"([{"name": "coarse", "mesh": [3, 2]}])");
  return job;
}

}  // namespace flexopt::test
