"""Small jobs of every kind whose work can be shared, and folders compared byte by byte."""

import json
import os
import pathlib
import subprocess

GUIDE = {
    "flexopt": 1,
    "design": {"family": "parallel_guide", "material": "stavax", "parameters": {
        "length": "100 mm", "width": "30 mm", "thickness": "0.5 mm", "spacing": "100 mm"}},
    "end_effector": {"mass": "1 kg", "inertia": ["1e-3 kg m^2"] * 3},
    "stroke": {"from": 0, "to": "10 mm", "points": 3},
    "frequencies": 3,
    "model": {"accuracy": "full", "mesh": [4, 2]},
}
THICKEST = {
    "variables": [{"parameter": "thickness", "min": "0.3 mm", "max": "0.8 mm"},
                  {"parameter": "length", "min": "80 mm", "max": "120 mm"}],
    "objective": {"maximise": "support_stiffness.uz", "over_stroke": "min"},
    "constraints": [{"quantity": "drive_load", "over_stroke": "max_abs", "max": "20 N"}],
    "starts": 3, "max_evaluations": 12,
}
SAMPLED = {"tolerances": {"thickness": "10 um", "length": "50 um"}, "tolerance_samples": {"count": 12, "seed": 1}}
MAPS = [{"parameters": [{"parameter": "thickness", "min": "0.3 mm", "max": "0.7 mm"},
                        {"parameter": "length", "min": "80 mm", "max": "120 mm"}],
         "points": [4, 3], "quantities": [{"quantity": "drive_load", "over_stroke": "last"}]},
        {"parameters": [{"parameter": "width", "min": "20 mm", "max": "40 mm"},
                        {"parameter": "length", "min": "80 mm", "max": "120 mm"}],
         "points": [2, 3], "quantities": [{"quantity": "max_stress", "over_stroke": "max"}]}]
SLSQP = {"library": "nlopt", "name": "LD_SLSQP"}


def jobs():
    """By name: a comparison, starts with a front and tolerances, starts without derivatives, a global search, samples and
    maps, and a list of designs."""
    compare = {**GUIDE, "name": "compare", "job": "compare", "models": [{"name": "coarse", "mesh": [3, 2]}],
               "samples": {"count": 10, "seed": 3, "vary": [
                   {"parameter": "thickness", "min": "0.3 mm", "max": "0.8 mm"}]}}
    compare.pop("model")
    return {
        "compare": compare,
        "starts": {**GUIDE, "name": "starts", "job": "optimise", **SAMPLED,
                   "optimise": {**THICKEST, "algorithm": SLSQP, "max_evaluations": 40, "pareto": {
                       "quantity": "drive_load", "over_stroke": "max_abs", "points": 3}}},
        "derivative_free": {**GUIDE, "name": "derivative_free", "job": "optimise",
                            "optimise": {**THICKEST, "algorithm": {"library": "nlopt", "name": "LN_COBYLA"}}},
        "global": {**GUIDE, "name": "global", "job": "optimise",
                   "optimise": {**THICKEST, "search": "global", "screened_designs": 24, "starts": 2}},
        "around": {**GUIDE, "name": "around", "job": "evaluate", **SAMPLED, "maps": MAPS,
                   "design": {"file": "guide.design.json",
                              **{key: value for key, value in GUIDE["design"].items() if key != "family"}}},
        "listed": {**{key: value for key, value in GUIDE.items() if key != "design"}, "name": "listed",
                   "job": "optimise", "optimise": {**{key: value for key, value in THICKEST.items() if key != "variables"},
                                "starts": 2, "max_evaluations": 6},
                   "designs": [{**GUIDE["design"], "name": name, "variables": THICKEST["variables"]}
                               for name in ("one", "two")]},
    }


def write(job, folder):
    """With the design in a file beside it where the job names one."""
    if "file" in job.get("design", {}):
        text = subprocess.run([os.environ["FLEXOPT_BINARY"], "designs", "--export", "parallel_guide"],
                              capture_output=True, text=True, check=True).stdout
        (pathlib.Path(folder) / job["design"]["file"]).write_text(text)
    file = pathlib.Path(folder) / f"{job['name']}.json"
    file.write_text(json.dumps(job))
    return file


def run(*command, seconds=120, **more):
    return subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=seconds,
                          **more)


CLOCKED = {"timings.json", "evaluations.seconds.jsonl"}


def contents(folder):
    """Of all files by their names, but for what the clock says."""
    folder = pathlib.Path(folder)
    found = {}
    for file in sorted(folder.rglob("*")):
        name = str(file.relative_to(folder))
        if file.is_file() and file.name not in CLOCKED:
            found[name] = file.read_bytes()
    result = json.loads(found["result.json"])
    if "comparison" in result:
        for model in result["comparison"]["models"]:
            for key in ("speed_up", "speed_up_with_reduction"):
                model.pop(key)
        found["result.json"] = json.dumps(result)
        found.pop("report.html")
    return found


def differences(one, other):
    one, other = contents(one), contents(other)
    return [name for name in sorted(one.keys() | other.keys()) if one.get(name) != other.get(name)]
