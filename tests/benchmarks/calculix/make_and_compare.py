#!/usr/bin/env python3
"""Leaf mechanisms in solid elements (CalculiX) against flexopt. See README.md.

make_and_compare.py --flexopt build/release/flexopt --work /tmp/calculix [--case NAME]...
                    [--store calculix_solids.json] [--reuse calculix_solids.json]
"""
import json
import math
import os
import shutil

import numpy as np

from program import parser_of, path_of, store, stored_numbers
from solid_model import REFERENCE, ROTATION, Case, Folded, Leaf, Mesh, Model, run_ccx

DIRECTIONS = ["ux", "uy", "uz", "rx", "ry", "rz"]
MODES = 6
# Small loads at O: perturbation steps are linear, the size only sets the printed digits.
UNIT_LOADS = [1.0, 1.0, 1.0, 0.01, 0.01, 0.01]


def guide(name, length, width, thickness, spacing, strokes):
    leaves = [Leaf((0, y, 0), (length, y, 0), width) for y in (spacing / 2, -spacing / 2)]
    design = {"family": "parallel_guide",
              "parameters": {"length": length, "width": width, "thickness": thickness,
                             "spacing": spacing}}
    return Case(name, thickness, leaves, (length, 0, 0), 1, strokes, 0.5, 4e-4, design)


def crossing(length, side, z, width):
    a = length / 2 * math.sqrt(0.5)
    return Leaf((-a, -side * a, z), (a, side * a, z), width)


def cross_hinge(name, length, width, thickness, gap, strokes):
    z = (width + gap) / 2
    leaves = [crossing(length, 1, z, width), crossing(length, -1, -z, width)]
    design = {"family": "cross_hinge",
              "parameters": {"length": length, "width": width, "thickness": thickness,
                             "gap": gap}}
    return Case(name, thickness, leaves, (0, 0, 0), 5, strokes, 0.3, 3e-4, design,
                steps_per_stroke=4)


def three_flexure(name, length, outer, inner, thickness, gap, strokes):
    z = inner / 2 + gap + outer / 2
    leaves = [crossing(length, 1, z, outer), crossing(length, -1, 0, inner),
              crossing(length, 1, -z, outer)]
    design = {"family": "three_flexure_cross_hinge",
              "parameters": {"length": length, "outer_width": outer, "inner_width": inner,
                             "thickness": thickness, "gap": gap}}
    return Case(name, thickness, leaves, (0, 0, 0), 5, strokes, 0.3, 3e-4, design,
                steps_per_stroke=4)


def curved_leaf(name, chord, angle, width, thickness, strokes):
    leaves = [Leaf((0, 0, 0), (chord, 0, 0), width, curve=angle)]
    design = {"family": "curved_leaf", "parameters": {"chord": chord, "angle": angle,
                                                      "width": width, "thickness": thickness}}
    return Case(name, thickness, leaves, (chord, 0, 0), 5, strokes, 0.3, 3e-4, design)


def folded(name, first, second, turn, width, thickness, strokes, design=None):
    """One leg along x, the other one turned by `turn` towards y from there on; elastic fold."""
    fold = (first, 0, 0)
    tip = (first + second * math.cos(turn), second * math.sin(turn), 0)
    leaf = {"name": "leaf", "base": {"body": "ground", "at": [0, 0, 0]}, "fold": {"at": fold},
            "tip": {"body": "end_effector", "at": tip}, "across": [0, 0, 1], "width": width,
            "thickness": thickness}
    design = design or {"mechanism": {
        "flexopt_design": 1, "leaves": [leaf], "drive": {"direction": "ux"},
        "bodies": [{"name": "end_effector", "at": tip}]}}
    legs = Folded([Leaf((0, 0, 0), fold, width), Leaf(fold, tip, width)])
    return Case(name, thickness, [legs], tip, 0, strokes, 0.5, 4e-4, design)


def folded_leaf(name, length, width, thickness, strokes):
    design = {"family": "folded_leaf", "fold": "elastic",
              "parameters": {"length": length, "width": width, "thickness": thickness}}
    return folded(name, length, length, math.pi / 2, width, thickness, strokes, design)


DEG = math.pi / 180
CASES = {c.name: (c, mesh) for c, mesh in [
    (guide("guide", 0.1, 0.03, 0.5e-3, 0.06, [0.01, 0.02]), Mesh(24, 14, 2)),
    (guide("wide_short_guide", 0.03, 0.06, 0.5e-3, 0.06, [0.0015, 0.003]), Mesh(20, 18, 2)),
    (guide("narrow_guide", 0.1, 0.005, 1e-3, 0.06, [0.1e-3, 0.01]), Mesh(28, 6, 2)),
    (guide("slender_guide", 0.1, 0.01, 1e-3, 0.06, [0.1e-3, 0.01]), Mesh(28, 8, 2)),
    (cross_hinge("cross_hinge", 0.1, 0.02, 0.35e-3, 0.005, [15 * DEG, 30 * DEG]),
     Mesh(14, 8, 1)),
    (three_flexure("three_flexure_cross_hinge", 0.1, 0.02, 0.04, 0.35e-3, 0.005,
                   [15 * DEG, 30 * DEG]), Mesh(14, 8, 1)),
    (curved_leaf("curved_leaf_30", 0.06, 30 * DEG, 0.02, 0.4e-3, [0.1 * DEG, 10 * DEG, 20 * DEG]),
     Mesh(24, 12, 2)),
    (curved_leaf("curved_leaf_90", 0.06, 90 * DEG, 0.02, 0.6e-3, [0.1 * DEG, 10 * DEG, 20 * DEG]),
     Mesh(24, 12, 2)),
    (curved_leaf("curved_leaf_90_wide", 0.08, 90 * DEG, 0.04, 0.4e-3, [-20 * DEG, -10 * DEG]),
     Mesh(24, 16, 2)),
    (folded_leaf("folded_leaf", 0.06, 0.03, 0.5e-3, [0.1e-3, 3e-3, 10e-3]), Mesh(20, 12, 2)),
    (folded_leaf("wide_folded_leaf", 0.04, 0.04, 0.3e-3, [2e-3, 6e-3]), Mesh(20, 12, 2)),
    (folded("acute_fold", 0.05, 0.04, 130 * DEG, 0.02, 0.4e-3, [0.1e-3, 3e-3]),
     Mesh(20, 10, 2)),
    (folded("obtuse_wide_fold", 0.03, 0.03, 50 * DEG, 0.04, 0.4e-3, [0.1e-3, 1e-3]),
     Mesh(20, 10, 2)),
]}


def hat(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def rotation_matrix(v):
    a = np.linalg.norm(v)
    h = hat(v)
    return (np.eye(3) + np.sinc(a / np.pi) * h
            + 0.5 * np.sinc(a / 2 / np.pi) ** 2 * (h @ h))


def spin_of_rate(v):
    """T in spin = T d(rotation vector)."""
    a, h = np.linalg.norm(v), hat(v)
    if a < 1e-6:
        return np.eye(3) + 0.5 * h
    return (np.eye(3) + (1 - math.cos(a)) / a**2 * h + (a - math.sin(a)) / a**3 * (h @ h))


def tables(dat):
    """Every printed table of a .dat file: [(title, {node: [3 values]})]."""
    result = []
    for line in dat.splitlines():
        words = line.split()
        if line.startswith((" displacements", " forces")):
            result.append((line.strip(), {}))
        elif len(words) == 4 and result and words[0].isdigit():
            try:
                result[-1][1][int(words[0])] = np.array([float(w) for w in words[1:]])
            except ValueError:
                pass
    return result


def eigenvalues(dat):
    found, inside = [], False
    for line in dat.splitlines():
        if "E I G E N V A L U E   O U T P U T" in line:
            inside = True
        elif "P A R T I C I P A T I O N" in line:
            inside = False
        words = line.split()
        if inside and len(words) == 5 and words[0].isdigit():
            found.append(float(words[1]))
    return found


def solve_case(case, mesh, folder, make_model=Model, linear=True):
    """CalculiX's answer at every stroke of a case. Without `linear` no stiffnesses and
    frequencies."""
    model = make_model(case, mesh)
    lines = model.header() + model.first_steps()
    before = sum(line.startswith("*STEP") for line in lines)
    for stroke in case.strokes:
        lines += model.stroke_step(stroke, case.steps_per_stroke)
    printed = tables(run_ccx(folder, "path", lines))
    node, dof = model.held()
    free = [(REFERENCE, i) if i < 3 else (ROTATION, i - 3) for i in range(6)]
    path = []
    for k, stroke in enumerate(case.strokes):
        step = k + 1 + before
        at_o, at_tip, force = [t[1] for t in printed[3 * k:3 * k + 3]]
        displacement, rotation = at_o[REFERENCE], at_o[ROTATION]
        o = model.nodes[REFERENCE] + displacement
        arms = {n: model.nodes[n] + at_tip[n] - o for n in force}
        # The rigid body carries every tip node where the rotation vector says.
        r = rotation_matrix(rotation)
        off = max(np.linalg.norm(r @ (model.nodes[n] - model.nodes[REFERENCE]) - a)
                  for n, a in arms.items())
        assert off < 1e-6 * np.linalg.norm(model.nodes[model.tip[0]]), off
        total = sum(force.values())
        moment = sum(np.cross(arms[n], f) for n, f in force.items())
        load = np.concatenate([total, moment])
        if not linear:
            path.append({"stroke": stroke, "drive_load": load[case.drive],
                         "displacement": displacement.tolist(), "rotation": rotation.tolist()})
            continue
        # Second derivative of the rigid body's rows times their forces, which a linear
        # perturbation leaves out: x = O + exp(spin) p, f . (spin x (spin x p))/2.
        moments = sum(np.outer(f, arms[n]) for n, f in force.items())
        geometric = np.zeros((6, 6))
        geometric[3:, 3:] = 0.5 * (moments + moments.T) - np.trace(moments) * np.eye(3)

        def perturbed(name, cards):
            shutil.copy(os.path.join(folder, "path.rout"), os.path.join(folder, name + ".rin"))
            return run_ccx(folder, name,
                           [f"*RESTART, READ, STEP={step}", "*STEP, PERTURBATION", *cards,
                            "*NODE PRINT, NSET=O", "U", "*END STEP"])

        to_spin = np.eye(6)
        to_spin[3:, 3:] = spin_of_rate(rotation)
        compliance = np.zeros((6, 6))
        for i in range(6):
            if i == case.drive:
                continue
            n, d = free[i]
            u = tables(perturbed("unit", ["*STATIC", "*CLOAD, OP=NEW",
                                          f"{n}, {d + 1}, {UNIT_LOADS[i]}"]))[0][1]
            compliance[:, i] = np.concatenate([u[REFERENCE], u[ROTATION]]) / UNIT_LOADS[i]
        compliance[case.drive, :] = 0
        compliance = to_spin @ compliance @ to_spin.T
        keep = [i for i in range(6) if i != case.drive]
        block = compliance[np.ix_(keep, keep)]
        asymmetry = np.abs(block - block.T).max() / np.abs(block).max()
        stiffness = np.linalg.inv(block)
        exact = np.linalg.inv(0.5 * (stiffness + stiffness.T) + geometric[np.ix_(keep, keep)])
        dat = perturbed("modes", ["*FREQUENCY", str(2 * MODES)])
        omega2 = eigenvalues(dat)
        shapes = np.array([np.concatenate([t[1][REFERENCE], t[1][ROTATION]])
                           for t in tables(dat)]).T
        shapes = to_spin @ shapes
        shapes[case.drive, :] = 0
        # Modes have unit modal mass.
        corrected = np.linalg.eigvalsh(np.diag(omega2) + shapes.T @ geometric @ shapes)
        path.append({
            "stroke": stroke, "drive_load": load[case.drive],
            "displacement": displacement.tolist(), "rotation": rotation.tolist(),
            "support_stiffness": {DIRECTIONS[i]: 1 / exact[k, k] for k, i in enumerate(keep)},
            "frequencies": (np.sqrt(corrected[:MODES]) / (2 * math.pi)).tolist(),
            "checks": {
                "asymmetry": asymmetry,
                "unbalanced_load": float(np.abs(np.delete(load, case.drive)).max()),
                "rigid_body_term_in_compliance":
                    float(max(abs(exact[k, k] / block[k, k] - 1) for k in range(5))),
                "rigid_body_term_in_frequency":
                    float(np.abs(np.sqrt(corrected[:MODES] / omega2[:MODES]) - 1).max())}})
    return {"unknowns": model.unknowns, "material": "plate",
            "mesh": [mesh.along, mesh.across, mesh.through, mesh.grade], "path": path}


def material_of(case):
    return {"youngs_modulus": case.youngs_modulus, "poissons_ratio": case.poissons_ratio,
            "density": case.density}


def record(case, solid):
    """What is stored of a case."""
    return {**{k: solid[k] for k in ("unknowns", "material", "mesh", "path")},
            "design": case.flexopt, "mass": case.mass, "inertia": case.inertia,
            **material_of(case)}


def job_of(case, model):
    return {"flexopt": 1, "name": case.name, "job": "evaluate",
            "design": {**case.flexopt, "material": material_of(case)},
            "end_effector": {"mass": case.mass, "inertia": [case.inertia] * 3},
            "stroke": {"at": case.strokes}, "model": model, "frequencies": MODES}


def run_flexopt(program, case, model, folder):
    return [{**p, "frequencies": p["frequencies"]["drive_locked"]}
            for p in path_of(program, job_of(case, model), folder)]


def differences(case, points, reference):
    """Percent, per stroke: {quantity: value}."""
    rows = []
    for p, q in zip(points, reference):
        row = {"drive": p["drive_load"] / q["drive_load"] - 1}
        # Parasitic motion relative to its largest component; frequencies: the worst.
        keep = [i for i in range(3) if i != case.drive]
        a, b = np.array(p["displacement"])[keep], np.array(q["displacement"])[keep]
        row["shift"] = float(np.abs(a - b).max() / np.abs(b).max())
        for d, k in q["support_stiffness"].items():
            row[d] = p["support_stiffness"][d] / k - 1
        f = np.array(p["frequencies"]) / np.array(q["frequencies"]) - 1
        for i, v in enumerate(f, 1):
            row[f"f{i}"] = float(v)
        rows.append({k: 100 * v for k, v in row.items()})
    return rows


def print_table(title, case, strokes, rows):
    names = ["drive", "shift"] + [d for i, d in enumerate(DIRECTIONS) if i != case.drive]
    names += [f"f{i}" for i in range(1, MODES + 1)]
    for stroke, row in zip(strokes, rows):
        worst = max(abs(v) for v in row.values())
        print(f"| {title} | {stroke:.4g} | " + " | ".join(f"{row[n]:+.2f}" for n in names)
              + f" | {worst:.2f} |", flush=True)


def main():
    options = parser_of(__doc__, CASES).parse_args()
    stored = stored_numbers(options, {"cases": {}})
    for name in options.case or CASES:
        case, mesh = CASES[name]
        if options.mesh:
            mesh = Mesh(*options.mesh)
        folder = os.path.join(options.work, name)
        if options.reuse:
            solid = stored["cases"][name]
        else:
            solid = solve_case(case, mesh, folder)
            print(json.dumps({"case": name, "unknowns": solid["unknowns"],
                              "checks": [p["checks"] for p in solid["path"]]}), flush=True)
        for title, model in [("full 16x4", {"accuracy": "full", "mesh": [16, 4]}),
                             ("full 20x6", {"accuracy": "full", "mesh": [20, 6]}),
                             ("reduced", {"accuracy": "reduced"})]:
            points = run_flexopt(options.flexopt, case, model,
                                 os.path.join(folder, title.replace(" ", "_")))
            print_table(f"{name}, {title}", case, case.strokes,
                        differences(case, points, solid["path"]))
        stored["cases"][name] = record(case, solid)
        store(options, stored)


if __name__ == "__main__":
    main()
