#!/usr/bin/env python3
"""Mechanisms of several bodies in solid elements (CalculiX) against flexopt.

mechanisms.py --flexopt build/release/flexopt --work /tmp/calculix [--case NAME]... [--store FILE]

The geometry is what `flexopt expand` prints of a job, so that any design file can be a case. Drive
loads and support stiffnesses are those of nonlinear steps (the latter between two small loads), the
frequencies those of the mechanism at rest.
"""
import argparse
import json
import math
import os
import shutil
import subprocess

import numpy as np

from make_and_compare import DIRECTIONS, eigenvalues, rotation_matrix, spin_of_rate, tables
from solid_model import (Leaf, Mesh, chunks, mesh_folded, mesh_leaf, orientation, plate_material,
                         run_ccx)

MATERIAL = {"youngs_modulus": 200e9, "poissons_ratio": 0.3, "density": 7800.0}
MASS, INERTIA = 0.5, 4e-4
MODES = 6

# name: (family, parameters, strokes, mesh of a leaf or leg[, choices])
CASES = {
    "double_parallelogram": ("double_parallelogram", {
        "length": 0.1, "width": 0.03, "thickness": 5e-4, "outer_spacing": 0.09,
        "inner_spacing": 0.06, "stage_mass": 0.2}, [0.004, 0.008], Mesh(16, 8, 1)),
    "reinforced_guide": ("reinforced_guide", {
        "length": 0.1, "width": 0.03, "thickness": 5e-4, "spacing": 0.06, "fraction": 0.6,
        "reinforcement_thickness": 4e-3}, [0.002, 0.004], Mesh(12, 12, 1)),
    "folded_leaf": ("folded_leaf", {"length": 0.06, "width": 0.03, "thickness": 5e-4},
                    [0.001, 0.003], Mesh(16, 10, 1)),
    "folded_leaf_elastic": (
        "folded_leaf", {"length": 0.06, "width": 0.03, "thickness": 5e-4}, [0.001, 0.003],
        Mesh(16, 10, 1), {"fold": "elastic"}),
    "spherical_joint_elastic": (
        "spherical_joint", {"length": 0.04, "width": 0.02, "thickness": 4e-4, "radius": 0.05},
        [0.02],
        Mesh(24, 14, 1), {"fold": "elastic"}),
    "cartwheel_hinge": ("cartwheel_hinge", {
        "length": 0.04, "width": 0.02, "thickness": 4e-4, "half_angle": 0.6, "hub_mass": 0.01},
        [0.06, 0.12], Mesh(14, 8, 1)),
    "tapered_leaf": ("tapered_leaf", {
        "length": 0.1, "base_width": 0.04, "tip_width": 0.02, "thickness": 5e-4},
        [0.004, 0.008], Mesh(20, 10, 1)),
    "curved_hinge": ("curved_hinge", {
        "chord": 0.06, "angle": math.radians(20), "width": 0.02, "thickness": 4e-4,
        "half_angle": 0.7, "gap": 1e-3}, [0.1, 0.2], Mesh(24, 12, 1)),
}


def job_of(name, accuracy="full"):
    family, parameters, strokes, _, *choices = CASES[name]
    return {"flexopt": 1, "name": name, "job": "evaluate",
            "design": {"family": family, "parameters": parameters, "material": MATERIAL,
                       **(choices[0] if choices else {})},
            "end_effector": {"mass": MASS, "inertia": [INERTIA] * 3},
            "stroke": {"at": [0] + strokes}, "model": {"accuracy": accuracy},
            "frequencies": MODES}


class Mechanism:
    """The solid mesh of a flat design and what every deck of it shares."""

    def __init__(self, design, mesh):
        self.bodies = {b["name"]: b for b in design["bodies"]}
        self.drive = design["drive"]["direction"]
        self.nodes, self.masses, self.on = {}, [], {}
        self.handles = {}  # body → (reference node, rotation node)
        for name, body in self.bodies.items():
            at = np.array(body["at"], float)
            self.handles[name] = (self.add(at), self.add(at))
            self.on[name] = []
            mass, inertia = float(body.get("mass", 0)), np.array(body.get("inertia", np.zeros((3, 3))))
            if name == "end_effector":
                mass, inertia = MASS, INERTIA * np.eye(3)
            self.add_masses(name, at, mass, np.diag(inertia))
        self.fixed, self.leaves = [], []
        for leaf in design["leaves"]:
            width = leaf["width"] if isinstance(leaf["width"], list) else [leaf["width"]] * 2
            if "fold" in leaf:
                self.add_folded(leaf, mesh)
                continue
            angle = leaf.get("curve", {}).get("angle", 0.0)
            solid = Leaf(tuple(leaf["base"]["at"]), tuple(leaf["tip"]["at"]), width[0],
                         tuple(leaf["across"]), width[1], angle)
            nodes, cells, base, tip, axes = mesh_leaf(solid, leaf["thickness"], mesh,
                                                      len(self.nodes) + 1)
            self.nodes.update(nodes)
            self.leaves.append((cells, axes, solid))
            for body, edge in ((leaf["base"]["body"], base), (leaf["tip"]["body"], tip)):
                (self.fixed if body == "ground" else self.on[body]).extend(edge)

    def add_folded(self, leaf, mesh):
        at = [tuple(leaf["base"]["at"]), tuple(leaf["fold"]["at"]), tuple(leaf["tip"]["at"])]
        legs = [Leaf(at[k], at[k + 1], leaf["width"], tuple(leaf["across"])) for k in range(2)]
        nodes, cells, base, tip, axes = mesh_folded(legs, leaf["thickness"], mesh,
                                                    len(self.nodes) + 1)
        self.nodes.update(nodes)
        self.leaves += zip(cells, axes, legs)
        for body, edge in ((leaf["base"]["body"], base), (leaf["tip"]["body"], tip)):
            (self.fixed if body == "ground" else self.on[body]).extend(edge)

    def add(self, place):
        self.nodes[len(self.nodes) + 1] = place
        return len(self.nodes)

    def add_masses(self, body, at, mass, inertia):
        """Pairs of point masses on the axes with these principal values."""
        if mass == 0:
            return
        squares = (sum(inertia) / 2 - inertia)  # sum of m x^2, m y^2, m z^2
        pairs = [k for k in range(3) if squares[k] > 1e-12 * max(sum(inertia), 1e-30)]
        if not pairs:
            self.masses.append((self.add(at), mass))
            self.on[body].append(self.masses[-1][0])
            return
        for k in pairs:
            share = mass / len(pairs)
            arm = np.sqrt(squares[k] / share)
            for side in (1, -1):
                self.masses.append((self.add(at + side * arm * np.eye(3)[k]), share / 2))
                self.on[body].append(self.masses[-1][0])

    def header(self):
        out = ["*NODE, NSET=NALL"]
        out += [f"{n}, {p[0]:.12g}, {p[1]:.12g}, {p[2]:.12g}" for n, p in self.nodes.items()]
        element, materials = 1, []
        for index, (cells, axes, leaf) in enumerate(self.leaves, 1):
            out.append(f"*ELEMENT, TYPE=C3D20R, ELSET=LEAF{index}")
            for cell in cells:
                out.append(f"{element}, " + ", ".join(map(str, cell[:15])) + ",")
                out.append(", ".join(map(str, cell[15:])))
                element += 1
            lines, thickness = orientation(index, leaf, axes)
            out += lines
            materials.append({"x": "ARC", "y": "FLAT"}[thickness])
        for index, (node, mass) in enumerate(self.masses, 1):
            out += [f"*ELEMENT, TYPE=MASS, ELSET=POINT{index}", f"{element}, {node}",
                    f"*MASS, ELSET=POINT{index}", f"{mass:.12g}"]
            element += 1
        e, nu = MATERIAL["youngs_modulus"], MATERIAL["poissons_ratio"]
        for name, thickness in (("FLAT", "y"), ("ARC", "x")):
            out += plate_material(name, e, nu, MATERIAL["density"], thickness)
        for index, material in enumerate(materials, 1):
            out.append(f"*SOLID SECTION, ELSET=LEAF{index}, MATERIAL={material}, "
                       f"ORIENTATION=AXES{index}")
        out += ["*NSET, NSET=GROUND", chunks(self.fixed)]
        for index, (name, nodes) in enumerate(self.on.items(), 1):
            reference, rotation = self.handles[name]
            out += [f"*NSET, NSET=BODY{index}", chunks(nodes),
                    f"*RIGID BODY, NSET=BODY{index}, REF NODE={reference}, ROT NODE={rotation}"]
        reference, rotation = self.handles["end_effector"]
        out += [f"*NSET, NSET=O\n{reference}, {rotation},", "*BOUNDARY", "GROUND, 1, 3, 0."]
        # held directions of the bodies
        for name, body in self.bodies.items():
            for direction in body.get("held", []):
                node, dof = self.degree(name, direction)
                out.append(f"{node}, {dof}, {dof}, 0.")
        return out

    def degree(self, body, direction):
        k = DIRECTIONS.index(direction)
        return self.handles[body][k // 3], k % 3 + 1

    def free(self):
        held = self.bodies["end_effector"].get("held", [])
        return [d for d in DIRECTIONS if d != self.drive and d not in held]


def solve(name, flexopt, folder, with_supports):
    """CalculiX's answers; flexopt's stiffness serves only to choose the size of small loads."""
    _, _, strokes, mesh, *_ = CASES[name]
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(folder, "job.json"), "w") as file:
        json.dump(job_of(name), file)
    design = json.loads(subprocess.run([flexopt, "expand", os.path.join(folder, "job.json")],
                                       check=True, capture_output=True, text=True).stdout)
    expected = run_flexopt(flexopt, name, "full", folder)
    model = Mechanism(design, mesh)
    reference, rotation = model.handles["end_effector"]
    node, dof = model.degree("end_effector", model.drive)
    rest = model.header() + ["*BOUNDARY", f"{node}, {dof}, {dof}, 0.", "*STEP", "*FREQUENCY",
                             str(MODES), "*END STEP"]
    omega2 = eigenvalues(run_ccx(folder, "rest", rest))
    lines = model.header()
    for stroke in strokes:
        lines += ["*STEP, NLGEOM, INC=200", "*RESTART, WRITE", "*CONTROLS, PARAMETERS=FIELD",
                  "1e-5, 1e-4", "*STATIC", "0.25, 1., 1e-6, 0.25", "*BOUNDARY",
                  f"{node}, {dof}, {dof}, {stroke:.12g}", "*NODE PRINT, NSET=O, FREQUENCY=1000",
                  "U, RF", "*END STEP"]
    printed = [t[1] for t in tables(run_ccx(folder, "path", lines))]
    path = [{"stroke": 0, "frequencies": (np.sqrt(omega2[:MODES]) / (2 * np.pi)).tolist()}]
    for step, stroke in enumerate(strokes, 1):
        at, force = printed[2 * step - 2], printed[2 * step - 1]
        supports = {}
        for direction in model.free() if with_supports else []:
            n, d = model.degree("end_effector", direction)
            ends = []
            # a load that moves it by some 2 um or 20 urad: well above the printed digits
            size = {"u": 2e-6, "r": 2e-5}[direction[0]] * expected[step]["support_stiffness"][direction]
            for sign in (1, -1):
                shutil.copy(os.path.join(folder, "path.rout"), os.path.join(folder, "finite.rin"))
                u = [t[1] for t in tables(run_ccx(folder, "finite", [
                    f"*RESTART, READ, STEP={step}", "*STEP, NLGEOM",
                    "*CONTROLS, PARAMETERS=FIELD", "1e-6, 1e-5", "*STATIC", "1., 1.",
                    "*CLOAD, OP=NEW", f"{n}, {d}, {sign * size:.15g}",
                    "*NODE PRINT, NSET=O, FREQUENCY=1000", "U", "*END STEP"]))][-1]
                ends.append(u)
            change = (ends[0][n][d - 1] - ends[1][n][d - 1])
            if direction[0] == "r":  # along the spin, not the component of the rotation vector
                spin = spin_of_rate(at[rotation]) @ (ends[0][rotation] - ends[1][rotation])
                change = spin[d - 1]
            supports[direction] = 2 * size / change
        path.append({"stroke": stroke, "drive_load": float(force[node][dof - 1]),
                     "displacement": at[reference].tolist(), "rotation": at[rotation].tolist(),
                     "support_stiffness": supports})
    return {"mesh": [mesh.along, mesh.across, mesh.through], "unknowns": 3 * len(model.nodes),
            "path": path}


def run_flexopt(program, name, accuracy, folder):
    with open(os.path.join(folder, "job.json"), "w") as file:
        json.dump(job_of(name, accuracy), file)
    out = os.path.join(folder, accuracy)
    subprocess.run([program, "run", os.path.join(folder, "job.json"), "--out", out, "--quiet"],
                   check=True, stdout=subprocess.DEVNULL)
    with open(os.path.join(out, "result.json")) as file:
        return json.load(file)["path"]


def percent(a, b):
    return f"{100 * (a / b - 1):+.2f}"


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--flexopt", required=True)
    parser.add_argument("--work", required=True, help="scratch folder")
    parser.add_argument("--case", action="append", choices=list(CASES))
    parser.add_argument("--supports", action="store_true",
                        help="support stiffnesses too: two more nonlinear steps each")
    parser.add_argument("--store", help="write CalculiX's numbers here")
    options = parser.parse_args()
    stored = {}
    print("Differences in percent, flexopt less CalculiX.\n")
    print("| case | accuracy | stroke | drive | " + " | ".join(DIRECTIONS) + " | f1 … f6 at rest |")
    print("|---|---|---|---|" + "---|" * 7)
    for name in options.case or CASES:
        folder = os.path.join(options.work, name)
        solid = solve(name, options.flexopt, folder, options.supports)
        stored[name] = solid
        for accuracy in ("full", "reduced"):
            ours = run_flexopt(options.flexopt, name, accuracy, folder)
            for p, q in zip(ours[1:], solid["path"][1:]):
                cells = [percent(p["support_stiffness"][d], q["support_stiffness"][d])
                         if d in q["support_stiffness"] else "" for d in DIRECTIONS]
                modes = ", ".join(percent(a, b) for a, b in
                                  zip(ours[0]["frequencies"]["drive_locked"],
                                      solid["path"][0]["frequencies"]))
                print(f"| {name} | {accuracy} | {p['stroke']:g} | "
                      f"{percent(p['drive_load'], q['drive_load'])} | " + " | ".join(cells) +
                      f" | {modes} |", flush=True)
        if options.store:
            with open(options.store, "w") as file:
                json.dump(stored, file, indent=1)


if __name__ == "__main__":
    main()
