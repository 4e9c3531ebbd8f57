#!/usr/bin/env python3
"""Guides and hinges that are bolted down crooked, warm or heavy in solid elements (CalculiX) against
flexopt. See README.md.

surroundings.py --flexopt build/release/flexopt --work /tmp/calculix [--case NAME]... [--store FILE]
"""
import os
from dataclasses import dataclass, field

import numpy as np

from make_and_compare import (DIRECTIONS, cross_hinge, curved_leaf, guide, job_of, material_of,
                              solve_case)
from program import expanded, parser_of, path_of, store, stored_numbers
from solid_model import Mesh, Model, chunks

ALPHA = 11e-6  # [1/K]


@dataclass
class Surroundings:
    turn: tuple = (0.0, 0.0, 0.0)  # of the base edge of the first leaf
    move: tuple = (0.0, 0.0, 0.0)
    warmth: list = field(default_factory=list)  # [K], one for each leaf
    gravity: tuple = (0.0, 0.0, 0.0)

    def linear(self):
        """Whether a perturbation step is one of the loads that it names alone."""
        return not self.warmth and not any(self.gravity)


class PlacedModel(Model):
    """A mesh whose first leaf has its base edge elsewhere, whose leaves are warm or heavy."""

    def __init__(self, case, mesh, around):
        super().__init__(case, mesh)
        self.around = around
        # the edge that sits elsewhere is a rigid body of its own
        self.handles = ()
        if any(around.turn) or any(around.move):
            self.handles = (len(self.nodes) + 1, len(self.nodes) + 2)
            count = len(self.base) // len(case.leaves)
            self.edge, self.base = self.base[:count], self.base[count:]
            for n in self.handles:
                self.nodes[n] = np.array(case.leaves[0].base)

    def header(self):
        out = super().header()
        if self.handles:
            reference, rotation = self.handles
            out = out[:-2] + ["*NSET, NSET=EDGE", chunks(self.edge),
                              f"*RIGID BODY, NSET=EDGE, REF NODE={reference}, ROT NODE={rotation}"
                              ] + out[-2:]
        if not self.around.warmth:
            return out
        lines = []
        for line in out:
            lines.append(line)
            if line.startswith("*MATERIAL"):
                lines += ["*EXPANSION, ZERO=0.", f"{ALPHA:.12g}"]
        for k, leaf in enumerate(self.leaves, 1):
            numbers = sorted({n for cell in leaf[0] for n in cell})
            lines += [f"*NSET, NSET=WARM{k}"] + [f"{n}," for n in numbers]
        return lines + ["*INITIAL CONDITIONS, TYPE=TEMPERATURE", "NALL, 0."]

    def first_steps(self):
        a, lines = self.around, []
        node, dof = self.held()
        lines += ["*STEP, NLGEOM, INC=200", "*RESTART, WRITE", "*CONTROLS, PARAMETERS=FIELD",
                  "1e-5, 1e-4", "*STATIC", "0.25, 1., 1e-6, 0.25",
                  "*BOUNDARY", f"{node}, {dof}, {dof}, 0."]
        for n, values in zip(self.handles, (a.move, a.turn)):
            lines += [f"{n}, {i + 1}, {i + 1}, {values[i]:.15g}" for i in range(3)]
        if a.warmth:
            lines += ["*TEMPERATURE"] + [f"WARM{k}, {t:.12g}" for k, t in enumerate(a.warmth, 1)]
        size = np.linalg.norm(a.gravity)
        if size:
            g = ", ".join(f"{x / size:.12g}" for x in a.gravity)
            lines += ["*DLOAD"] + [f"LEAF{k}, GRAV, {size:.12g}, {g}"
                                   for k in range(1, len(self.leaves) + 1)]
            lines += ["*CLOAD"] + [f"{n}, {i + 1}, {self.case.mass / 6 * a.gravity[i]:.15g}"
                                   for n in self.masses for i in range(3) if a.gravity[i]]
        return lines + ["*END STEP"]


def the_guide(name, strokes=(1e-4, 0.005, 0.01)):
    return guide(name, 0.1, 0.03, 0.5e-3, 0.06, list(strokes))


MRAD = 1e-3
GUIDE = Mesh(24, 14, 2)
CASES = {case.name: (case, mesh, around) for case, mesh, around in [
    (the_guide("guide_as_designed"), GUIDE, Surroundings()),
    *[(the_guide(f"guide_turned_{axis}_{size:g}_mrad"), GUIDE,
       Surroundings(turn=tuple(size * MRAD * np.eye(3)["xyz".index(axis)])))
      for axis, size in (("x", 0.5), ("x", 2), ("y", 0.5), ("y", 1), ("y", 2), ("z", 2))],
    (the_guide("guide_moved"), GUIDE, Surroundings(move=(20e-6, 50e-6, 100e-6))),
    (cross_hinge("cross_hinge_placed", 0.1, 0.02, 0.35e-3, 0.005, [0.01, 0.2]), Mesh(14, 8, 1),
     Surroundings(turn=(1e-3, -1.5e-3, 2e-3), move=(0, 0, 50e-6))),
    (the_guide("guide_warm"), GUIDE, Surroundings(warmth=[20.0, 20.0])),
    (the_guide("guide_one_leaf_warm"), GUIDE, Surroundings(warmth=[8.0, 0.0])),
    (curved_leaf("curved_leaf_warm", 0.06, np.pi / 6, 0.02, 0.4e-3, [0.01, 0.1]), Mesh(24, 12, 2),
     Surroundings(warmth=[50.0])),
    (the_guide("guide_sideways"), GUIDE, Surroundings(gravity=(0, 0, -98.1))),
    (the_guide("guide_hanging"), GUIDE, Surroundings(gravity=(98.1, 0, 0))),
]}


def run_flexopt(program, case, around, model, folder):
    job = job_of(case, model)
    job["design"]["material"]["thermal_expansion"] = ALPHA
    names = [leaf["name"] for leaf in expanded(program, job, folder)["leaves"]]
    if any(around.turn) or any(around.move):
        job["assembly"] = [{"leaf": names[0], "end": "base", "move": around.move,
                            "turn": around.turn}]
    if around.warmth:
        job["temperature"] = {"leaves": dict(zip(names, around.warmth))}
    if any(around.gravity):
        job["gravity"] = around.gravity
    return path_of(program, job, folder)


def described(case, around):
    """What a test needs to build the same mechanism."""
    return {"design": case.flexopt, "mass": case.mass, "inertia": case.inertia,
            **material_of(case), "thermal_expansion": ALPHA, "turn": around.turn,
            "move": around.move, "warmth": around.warmth, "gravity": around.gravity}


def row(p, q):
    """Percent: drive load, stiffnesses, worst frequency; then motions of O, ours and theirs."""
    percent = lambda a, b: f"{100 * (a / b - 1):+.2f}"
    cells = [percent(p["drive_load"], q["drive_load"])]
    for d in DIRECTIONS:
        k = q.get("support_stiffness", {})
        cells.append(percent(p["support_stiffness"][d], k[d]) if d in k else "")
    if "frequencies" in q:
        f = np.array(p["frequencies"]["drive_locked"]) / np.array(q["frequencies"]) - 1
        cells.append(f"{100 * f[np.abs(f).argmax()]:+.2f}")
    else:
        cells.append("")
    motion = lambda x: " ".join(f"{1e6 * v:.3f}" for v in x["displacement"] + x["rotation"])
    return cells + [motion(p), motion(q)]


def main():
    options = parser_of(__doc__, CASES).parse_args()
    stored = stored_numbers(options, {})
    print("| case | accuracy | stroke | drive | " + " | ".join(DIRECTIONS)
          + " | worst frequency | motion of O, flexopt [um, urad] | CalculiX |")
    for name in options.case or CASES:
        case, mesh, around = CASES[name]
        mesh = Mesh(*options.mesh) if options.mesh else mesh
        folder = os.path.join(options.work, name)
        if options.reuse:
            solid = stored[name]
        else:
            solid = solve_case(case, mesh, folder, make_model=lambda *a: PlacedModel(*a, around),
                               linear=around.linear())
        for title, model in (("full 16x4", {"accuracy": "full", "mesh": [16, 4]}),
                             ("full 20x6", {"accuracy": "full", "mesh": [20, 6]}),
                             ("default", {})):
            ours = run_flexopt(options.flexopt, case, around, model,
                               os.path.join(folder, title.replace(" ", "_")))
            for p, q in zip(ours, solid["path"]):
                print(f"| {name} | {title} | {p['stroke']:g} | " + " | ".join(row(p, q)) + " |",
                      flush=True)
        stored[name] = {**described(case, around), **solid}
        store(options, stored)


if __name__ == "__main__":
    main()
