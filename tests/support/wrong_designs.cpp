#include "support/wrong_designs.hpp"

namespace flexopt::test {

using nlohmann::json;

json cantilever() {
  return json::parse(R"({
    "flexopt_design": 1,
    "parameters": {"length": {"unit": "m", "above": 0, "default": "80 mm"},
                   "count": {"unit": "1", "default": 3}},
    "bodies": [{"name": "end_effector", "at": ["length", 0, 0]}],
    "leaves": [{"name": "leaf", "base": {"body": "ground", "at": [0, 0, 0]},
                "tip": {"body": "end_effector", "at": ["length", 0, 0]},
                "across": [0, 0, 1], "width": "20 mm", "thickness": "0.3 mm"}],
    "drive": {"direction": "uy"}})");
}

json changed(const char* pointer, const json& value) {
  json document = cantilever();
  document[json::json_pointer(pointer)] = value;
  return document;
}

namespace {

// A list of one part of the library, joined to the end-effector.
json leaf_part(const char* joined, double thickness) {
  return {{{"name", "p"},
           {"design", "leaf_spring"},
           {"join", {{joined, "end_effector"}}},
           {"parameters", {{"length", 0.08}, {"width", 0.02}, {"thickness", thickness}}}}};
}

// A list of one spring or joint on the end-effector.
json on_end_effector(const json& more) {
  json item{{"name", "s"}, {"body", "end_effector"}, {"at", {0, 0, 0}}};
  item.update(more);
  return json::array({item});
}

}  // namespace

const std::vector<WrongDesign>& wrong_designs() {
  static const std::vector<WrongDesign> designs{
      {"/leaves/0/tip/body", "end_efector", "/leaves/0/tip/body", "did you mean 'end_effector'"},
      {"/leaves/0/tip/at/0", "lenght", "/leaves/0/tip/at/0", "length"},
      {"/leaves/0/tip/at/0", "length^2", "/leaves/0/tip/at/0", "expected a length"},
      {"/leaves/0/tip/at/0", "length + 1 s", "/leaves/0/tip/at/0", "added"},
      {"/leaves/0/tip/at/0", "sqrt(-length)*sqrt(length)", "/leaves/0/tip/at/0", "no finite value"},
      {"/leaves/0/tip/at/0", "5 kg", "/leaves/0/tip/at/0", "expected a length"},
      {"/leaves/0/width", "-20 mm", "/leaves/0/width", "must be positive"},
      {"/leaves/0/thickness", "30 mm", "/leaves/0/thickness", "thinner than long and wide"},
      {"/leaves/0/across", {1, 0, 0}, "/leaves/0/across", "lies across"},
      {"/leaves/0/tip/at", {0, 0, 0}, "/leaves/0/tip/at", "one place"},
      {"/leaves/0/wide", 1, "/leaves/0/wide", "unknown key"},
      {"/leaves/0/frame", "arm", "/leaves/0/frame", "no such frame"},
      {"/leaves/0/when", "tip == rigid", "/leaves/0/when", "no option 'tip'"},
      {"/leaves/0/name", "leaf {i}", "/leaves/0/name", "unknown name 'i'"},
      {"/leaves/0/name", "leaf {count/2}", "/leaves/0/name = 1.5", "whole number"},
      {"/leaves/0/name", "leaf {length}", "/leaves/0/name", "expected a plain number"},
      {"/leaves/0/name", "leaf {1/0*count}", "/leaves/0/name", "no finite value"},
      {"/leaves/0/tip/body", "{count}{2*}", "/leaves/0/tip/body", "ends"},
      {"/leaves/0/may_cross", "all", "/leaves/0/may_cross", "expected"},
      {"/leaves/0/repeat", {{"i", {1, 2}}}, "/leaves/0/name", "another leaf has this name"},
      {"/leaves/0/repeat", {{"i", {1, 1e5}}}, "/leaves/0/repeat/i", "at most 1000 copies"},
      {"/leaves/0/repeat", {{"length", {1, 2}}}, "/leaves/0/repeat/length", "has this name"},
      {"/leaves/0/curve", {{"angle", "200 deg"}}, "/leaves/0/curve/angle", "half a turn"},
      {"/leaves/0/diameter", "1 mm", "/leaves/0/width", "diameter alone"},
      {"/parameters/sin", {{"unit", "m"}}, "/parameters/sin", "meaning of its own"},
      {"/parameters/a b", {{"unit", "m"}}, "/parameters/a b", "letters, digits"},
      {"/parameters/length/unit", "mm", "/parameters/length/unit", "SI unit"},
      {"/parameters/length/unit", " m", "/parameters/length/unit", "SI unit"},
      {"/parameters/length/default", -1, "/parameters/length/default", "0 < value"},
      {"/parameters/length/example", "1 cm", "/parameters/length/example", "there is a default"},
      {"/parameters/more",
       {{"unit", "m"}, {"above", 0}, {"example", -1}},
       "/parameters/more/example",
       "0 < value"},
      {"/parameters/length/min", 0, "/parameters/length/above", "one of the two"},
      {"/let", {{"a", "b"}, {"b", "a"}}, "/let/a", "in a circle"},
      {"/let", {{"length", 1}}, "/let/length", "has this name"},
      {"/rules", {{{"that", "length"}, {"else", "x"}}}, "/rules/0/that", "compares"},
      {"/rules",
       {{{"that", "length < 1 cm"}, {"else", "too long"}}},
       "/design/parameters/length",
       "too long"},
      {"/bodies/0/name", "stage", "", "end_effector"},
      {"/bodies/1",
       {{"name", "end_effector"}, {"at", {0, 0, 0}}},
       "/bodies/1/name",
       "another body"},
      {"/bodies/1", {{"name", "loose"}, {"at", {0, 0, 0}}}, "/bodies/1", "no leaf ties it"},
      {"/bodies/1", {{"name", "ground"}, {"at", {0, 0, 0}}}, "/bodies/1/name", "there already"},
      {"/bodies/0/density", "7800 kg/m^3", "/bodies/0/box", "of a box"},
      {"/bodies/0/held", {"ux", "up"}, "/bodies/0/held/1", "did you mean"},
      {"/bodies/0/held",
       {{{"displacement", {0, 0, 0}}}},
       "/bodies/0/held/0/displacement",
       "has a direction"},
      {"/bodies/0/held", json::array({json::object()}), "/bodies/0/held/0", "one of the two"},
      {"/leaves/0/fold",
       {{"at", {0.05, 0, 0}}, {"angle", 1}},
       "/leaves/0/fold/angle",
       "unknown key"},
      {"/leaves/0/fold", {{"at", {0, 0, 0}}}, "/leaves/0/fold/at", "one place"},
      {"/leaves/0/fold", {{"at", {0.05, 0.02, 0.01}}}, "/leaves/0/across", "normal to base"},
      {"/leaves/0/fold", {{"at", {0.2, 1e-4, 0}}}, "/leaves/0/fold/at", "at least 5 deg"},
      {"/leaves/0/fold",
       {{"at", {0.05, 0.02, 0}}, {"radius", "-1 mm"}},
       "/leaves/0/fold/radius",
       "0 or more"},
      {"/leaves/0/fold",
       {{"at", {0.05, 0.02, 0}}, {"radius", "1 kg"}},
       "/leaves/0/fold/radius",
       "length"},
      {"/leaves/0/fold",
       {{"at", {0.05, 0.02, 0}}, {"radius", "80 mm"}},
       "/leaves/0/fold/radius",
       "less than half of each leg"},
      {"/frames",
       {{{"name", "a"}, {"in", "b"}}, {{"name", "b"}, {"in", "a"}}},
       "/frames/",
       "in a circle"},
      {"/frames", {{{"name", "a"}, {"in", "c"}}}, "/frames/0/in", "no such frame"},
      {"/frames", {{{"name", "a"}, {"at", {"1/0*length", 0, 0}}}}, "/frames/0/at/0", "finite"},
      {"/frames",
       {{{"name", "a"}, {"turn", json::array({json::array({"w", 1})})}}},
       "/frames/0/turn/0/0",
       "expected"},
      {"/joints", on_end_effector({{"type", "revolute"}}), "/joints/0/axis", "required"},
      {"/springs", on_end_effector(json::object()), "/springs/0/stiffness", "one of them"},
      {"/parts", leaf_part("stage", 3e-4), "/parts/0/join", "the part has no such body"},
      {"/parts", leaf_part("end_effector", 0.03), "/parts/0", "of the family leaf_spring"},
      {"/parts", leaf_part("end_effector", 3e-4), "/parts/0",
       "intersect when undeflected; leaves with \"may_cross\" may"},
      {"/parts",
       {{{"name", "p"}, {"design", "paralel_guide"}}},
       "/parts/0/design",
       "did you mean 'parallel_guide'"},
      {"/parts",
       {{{"name", "p"}, {"design", "parallel_guide"}}},
       "/parts/0/parameters/",
       "the part needs it"},
      {"/drive/body", "stage", "/drive/body", "no such body"},
      {"/drive/direction", "y", "/drive/direction", "uy"},
      {"/flexopt_design", 2, "/flexopt_design", "expected"},
      {"/flexopt_desing", 1, "/flexopt_desing", "did you mean 'flexopt_design'"},
      {"/bodies", json::array(), "/leaves/0/tip/body", "no such body"},
      {"/bodies/0/at", {0, 0}, "/bodies/0/at", "3 x"},
      {"/bodies/0/at", {"length", 0, nullptr}, "/bodies/0/at/2", "expected"},
      {"/bodies/0/mass", "2 m", "/bodies/0/mass", "expected a mass"},
      {"/bodies/0/on", {{"leaf", "leaf"}, {"at", {0, 0, 0}}}, "/bodies/0/at", "one of the two"},
      {"/bodies/0/inertia", {1, 2}, "/bodies/0/inertia", "3 x"},
      {"/bodies/0/inertia", {-1, 0, 1}, "/bodies/0/inertia", "none below zero"},
      {"/bodies/0/mass", "-1 g", "/bodies/0/mass", "not negative"},
      {"/leaves/0/base/body", nullptr, "/leaves/0/base/body", "expected"},
      {"/leaves/0/width", {"20 mm", "10 mm", "5 mm"}, "/leaves/0/width", "expected"},
      {"/leaves/0/width", {{"profile", "0.02 m*(s - 0.5)"}}, "/leaves/0/width", "must be positive"},
      {"/leaves/0/width", {{"profile", "0.02 m * s^2 +"}}, "/leaves/0/width/profile", "it ends"},
      {"/leaves/0/width", {{"profile", "0.02 kg * s"}}, "/leaves/0/width/profile", "a length"},
      {"/leaves/0/thickness", 0, "/leaves/0/thickness", "must be positive"},
      {"/leaves/0/width",
       {{"profile", "0.02 m*(1 + max(0, min(1, 1000*(s - 0.5))))"}},
       "/leaves/0/width/profile",
       "steps at s = 0.5"},
      {"/leaves/0/thickness",
       {{"profile", "0.3 mm*(1 - 0.8*exp(-((s - 0.517)/0.005)^2))"}},
       "/leaves/0/thickness/profile",
       "varies so steeply"},
      {"/leaves/0/thickness", {{"profile", "(0.3 mm)*s"}}, "/leaves/0", "positive all along"},
      {"/leaves/0/thickness", "1/0", "/leaves/0/thickness", "no finite value"},
      {"/leaves/0/thickness", "2 length", "/leaves/0/thickness", "needs '*'"},
      {"/leaves/0/material", "stavaks", "/leaves/0/material", "did you mean"},
      {"/leaves/0/reinforcement",
       {{"fraction", 1.5}, {"thickness", "2 mm"}},
       "/leaves/0/reinforcement/fraction",
       "0 < fraction < 1"},
      {"/leaves/0/reinforcement", {{"fraction", 0.5}}, "/leaves/0/reinforcement", "required"},
      {"/leaves/0/repeat", {{"i", {1, 2.5}}}, "/leaves/0/repeat/i", "whole number"},
      {"/leaves/0/repeat", {{"i", json::array({1})}}, "/leaves/0/repeat/i", "2 x"},
      {"/options", {{"tip", {{"choices", json::array()}}}}, "/options/tip/choices", "1 to"},
      {"/options", {{"tip", {{"choices", {"a", "a"}}}}}, "/options/tip/choices/1", "already"},
      {"/options", {{"length", {{"choices", {"a"}}}}}, "/options/length", "a parameter has this"},
      {"/options", {{"file", {{"choices", {"a"}}}}}, "/options/file", "meaning of its own"},
      {"/drive/body", "ground", "/drive", "there is no body"},
      {"/springs",
       on_end_effector({{"other", "end_effector"}, {"other_at", {1, 0, 0}}, {"stiffness", 1}}),
       "/springs/0", "ties a body to itself"},
      {"/joints", on_end_effector({{"type", "ball"}}), "/joints/0/type", "spherical"},
      {"/springs", on_end_effector({{"other_at", {0, 0, 0}}, {"stiffness", 5}}),
       "/springs/0/other_at", "coincide"},
      {"/springs", on_end_effector({{"other_at", {0, 0, 1}}, {"stiffness", -5}}),
       "/springs/0/stiffness", "negative"},
      {"/drives", json::array({{{"name", "x"}, {"direction", "ux"}}}), "/drive", "one of the two"},
  };
  return designs;
}

}  // namespace flexopt::test
