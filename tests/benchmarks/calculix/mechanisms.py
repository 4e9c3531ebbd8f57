#!/usr/bin/env python3
"""Mechanisms of several bodies in solid elements (CalculiX) against flexopt.

mechanisms.py --flexopt build/release/flexopt --work /tmp/calculix [--case NAME]... [--store FILE]

The geometry is what `flexopt expand` prints of a job, so that any design file can be a case. Linear
steps at rest give drive stiffnesses, support stiffnesses and frequencies; nonlinear steps the drive
loads at the strokes, and perturbation steps about the last one (--supports) the stiffnesses and
frequencies there.
"""
import json
import math
import os
import shutil

import numpy as np

from make_and_compare import DIRECTIONS, eigenvalues, hat, rotation_matrix, spin_of_rate, tables
from program import expanded, parser_of, path_of, store, stored_numbers
from solid_model import (Leaf, Mesh, Wire, chunks, isotropic_material, mesh_folded, mesh_leaf,
                         mesh_wire, node_cards, plate_material, run_ccx, solid_cards)

MATERIAL = {"youngs_modulus": 200e9, "poissons_ratio": 0.3, "density": 7800.0}
MASS, INERTIA = 0.5, 4e-4
MODES = 6
JOBS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../designs/jobs")

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
        Mesh(16, 10, 2), {"fold": "elastic"}),
    "spherical_joint_elastic": (
        "spherical_joint", {"length": 0.04, "width": 0.02, "thickness": 4e-4, "radius": 0.05},
        [0.02],
        Mesh(16, 8, 2), {"fold": "elastic"}),
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
# Jobs of the gallery, and the mesh of a leaf or leg of each.
GALLERY = {
    "parallel_guide": Mesh(16, 10, 1),
    "cross_hinge": Mesh(14, 8, 1),
    "roberts_guide": Mesh(16, 10, 1),
    "butterfly_hinge": Mesh(14, 8, 1),
    "infinity_hinge": Mesh(12, 6, 1),
    "trivot_hinge": Mesh(16, 8, 1),
    "folded_leaf_stage": Mesh(10, 8, 1),
    "five_strut_guide": Mesh(16, 8, 1),
    "xy_stage": Mesh(14, 8, 1),
    "tip_tilt_stage": Mesh(16, 6, 1),
    "spherical_joint": Mesh(10, 6, 1),
    "diaphragm": Mesh(16, 8, 1),
    "bridge_amplifier": Mesh(8, 8, 1),
    "hexapod": Mesh(16, 8, 1),
    "overconstrained_guide": Mesh(16, 8, 1),
}


def si(text):
    number, unit = str(text).split(" ", 1) if isinstance(text, str) else (text, "")
    return float(number) * {"": 1, "kg": 1, "kg m^2": 1, "kg/m^3": 1, "GPa": 1e9}[unit]


def job_of(name):
    """What the program runs, with SI numbers where this script needs them."""
    if name in CASES:
        family, parameters, strokes, _, *choices = CASES[name]
        return {"flexopt": 1, "name": name, "job": "evaluate",
                "design": {"family": family, "parameters": parameters, "material": MATERIAL,
                           **(choices[0] if choices else {})},
                "end_effector": {"mass": MASS, "inertia": [INERTIA] * 3},
                "stroke": {"at": [0] + strokes}, "frequencies": MODES}
    with open(os.path.join(JOBS, name + ".json")) as file:
        job = json.load(file)
    del job["expect"]
    material = job["design"]["material"]
    job["design"]["material"] = {name: si(material[name]) for name in MATERIAL}
    payload = job["end_effector"]
    job["end_effector"] = {"mass": si(payload["mass"]),
                           "inertia": [si(x) for x in payload["inertia"]]}
    if job["stroke"].get("points", 0) > 3:
        job["stroke"]["points"] = 2
    return {**job, "frequencies": MODES}


class Mechanism:
    """The solid mesh of a flat design and what every deck of it shares."""

    def __init__(self, design, mesh, job):
        self.material, payload = job["design"]["material"], job["end_effector"]
        self.bodies = {b["name"]: b for b in design["bodies"]}
        self.nodes, self.masses, self.on = {}, [], {}
        self.handles = {}  # body → (reference node, rotation node)
        for name, body in self.bodies.items():
            at = np.array(body["at"], float)
            self.handles[name] = (self.add(at), self.add(at))
            self.on[name] = []
            mass, inertia = float(body.get("mass", 0)), np.array(body.get("inertia", np.zeros((3, 3))))
            if name == "end_effector":
                mass, inertia = payload["mass"], np.diag(payload["inertia"])
            self.add_masses(name, at, mass, np.diag(inertia))
        self.fixed, self.leaves = [], []
        for leaf in design["leaves"]:
            if "fold" in leaf:
                self.add_folded(leaf, mesh)
                continue
            if "diameter" in leaf:
                solid = Wire(tuple(leaf["base"]["at"]), tuple(leaf["tip"]["at"]),
                             leaf["diameter"], tuple(leaf["across"]))
                nodes, cells, base, tip, axes = mesh_wire(solid, mesh.along, mesh.grade,
                                                          len(self.nodes) + 1)
            else:
                width = leaf["width"] if isinstance(leaf["width"], list) else [leaf["width"]] * 2
                angle = leaf.get("curve", {}).get("angle", 0.0)
                solid = Leaf(tuple(leaf["base"]["at"]), tuple(leaf["tip"]["at"]), width[0],
                             tuple(leaf["across"]), width[1], angle)
                nodes, cells, base, tip, axes = mesh_leaf(solid, leaf["thickness"], mesh,
                                                          len(self.nodes) + 1)
            self.nodes.update(nodes)
            self.leaves.append((cells, axes, solid))
            self.clamp(leaf, base, tip)
        self.add_drives(design)

    def add_folded(self, leaf, mesh):
        at = [tuple(leaf["base"]["at"]), tuple(leaf["fold"]["at"]), tuple(leaf["tip"]["at"])]
        legs = [Leaf(at[k], at[k + 1], leaf["width"], tuple(leaf["across"])) for k in range(2)]
        nodes, parts, base, tip = mesh_folded(legs, leaf["thickness"], mesh, len(self.nodes) + 1)
        self.nodes.update(nodes)
        self.leaves += parts
        self.clamp(leaf, base, tip)

    def clamp(self, leaf, base, tip):
        for body, edge in ((leaf["base"]["body"], base), (leaf["tip"]["body"], tip)):
            (self.fixed if body == "ground" else self.on[body]).extend(edge)

    def add_drives(self, design):
        """self.drives: (name, node, degree of freedom) that the strokes prescribe. A stroke between
        two bodies is the displacement of a node of its own."""
        self.drives, self.relative = [], []
        for drive in design.get("drives") or [design["drive"]]:
            body, direction = drive.get("body", "end_effector"), drive["direction"]
            node, dof = self.degree(body, direction)
            if drive.get("other", "ground") != "ground":
                assert direction[0] == "u", "turns between two bodies are not written"
                other = self.degree(drive["other"], direction)[0]
                own = self.add(np.array(self.bodies[body]["at"], float))
                self.relative.append((body, drive["other"], node, other, own, dof))
                node = own
            self.drives.append((drive.get("name"), node, dof))

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
        solids, sections, elements = solid_cards(self.leaves)
        out = node_cards(self.nodes) + solids
        for index, (node, mass) in enumerate(self.masses, 1):
            out += [f"*ELEMENT, TYPE=MASS, ELSET=POINT{index}", f"{elements + index}, {node}",
                    f"*MASS, ELSET=POINT{index}", f"{mass:.12g}"]
        e, nu, density = (self.material[name] for name in MATERIAL)
        for name, thickness in (("FLAT", "y"), ("ARC", "x"), ("WIRE", "")):
            out += plate_material(name, e, nu, density, thickness)
        out += isotropic_material("CORNER", e, nu, density)
        out += sections
        out += ["*NSET, NSET=GROUND", chunks(self.fixed)]
        for index, (name, nodes) in enumerate(self.on.items(), 1):
            reference, rotation = self.handles[name]
            out += [f"*NSET, NSET=BODY{index}", chunks(nodes),
                    f"*RIGID BODY, NSET=BODY{index}, REF NODE={reference}, ROT NODE={rotation}"]
        for _, _, node, other, own, dof in self.relative:
            out += ["*EQUATION", "3", f"{node}, {dof}, 1., {other}, {dof}, -1., {own}, {dof}, -1."]
            out += ["*BOUNDARY"] + [f"{own}, {d}, {d}, 0." for d in (1, 2, 3) if d != dof]
        out += ["*NSET, NSET=O", chunks(self.watched()), "*BOUNDARY", "GROUND, 1, 3, 0."]
        # held directions of the bodies
        for name, body in self.bodies.items():
            for direction in body.get("held", []):
                node, dof = self.degree(name, direction)
                out.append(f"{node}, {dof}, {dof}, 0.")
        return out

    def watched(self):
        return sorted({n for pair in self.handles.values() for n in pair}
                      | {node for _, node, _ in self.drives})

    def degree(self, body, direction):
        k = DIRECTIONS.index(direction)
        return self.handles[body][k // 3], k % 3 + 1

    def prescribed(self, stroke):
        """*BOUNDARY lines of a stroke: one number, or one by the name of each drive."""
        values = [stroke.get(name) if isinstance(stroke, dict) else stroke
                  for name, _, _ in self.drives]
        return ["*BOUNDARY"] + [f"{node}, {dof}, {dof}, {value:.15g}"
                                for (_, node, dof), value in zip(self.drives, values)]

    def rest(self):
        return 0.0 if self.drives[0][0] is None else {name: 0.0 for name, _, _ in self.drives}

    def motions(self):
        """(body, direction) of what a load may move when the drives are held: the end-effector, the
        turns of the other bodies, and all of two bodies with a drive between them but the motion of
        the second one along it, which is that of the first."""
        taken = {(node, dof) for _, node, dof in self.drives}
        taken |= {(other, dof) for _, _, _, other, _, dof in self.relative}
        whole = {"end_effector", *(b for pair in self.relative for b in pair[:2])}
        return [(b, d) for b in self.bodies for d in (DIRECTIONS if b in whole else DIRECTIONS[3:])
                if self.degree(b, d) not in taken and d not in self.bodies[b].get("held", [])]

    def named(self, values):
        values = list(values)
        return values[0] if self.drives[0][0] is None else {
            drive[0]: v for drive, v in zip(self.drives, values)}


# Sizes of the loads of linear steps: they only set the printed digits.
SIZES = {"u": 1e3, "r": 10.0}


def at_rest(model, folder):
    """Linear steps: each drive alone by a small stroke, then each load with the drives held."""
    lines = model.header()
    small = {"u": 1e-6, "r": 1e-4}
    strokes = [small["r" if node in {h[1] for h in model.handles.values()} else "u"]
               for _, node, _ in model.drives]
    for k in range(len(model.drives)):
        values = {d[0]: strokes[j] if j == k else 0.0 for j, d in enumerate(model.drives)}
        lines += ["*STEP", "*STATIC", *model.prescribed(values),
                  "*NODE PRINT, NSET=O", "U, RF", "*END STEP"]
    free = [d for b, d in model.motions() if b == "end_effector"]
    for d in free:
        node, dof = model.degree("end_effector", d)
        lines += ["*STEP", "*STATIC", *model.prescribed(model.rest()),
                  "*CLOAD, OP=NEW", f"{node}, {dof}, {SIZES[d[0]]}",
                  "*NODE PRINT, NSET=O", "U", "*END STEP"]
    printed = [t[1] for t in tables(run_ccx(folder, "linear", lines))]
    count = len(model.drives)
    stiffness = [float(printed[2 * k + 1][node][dof - 1]) / strokes[k]
                 for k, (_, node, dof) in enumerate(model.drives)]
    supports = {}
    for d, moved in zip(free, printed[2 * count:]):
        node, dof = model.degree("end_effector", d)
        supports[d] = SIZES[d[0]] / float(moved[node][dof - 1])
    modes = model.header() + model.prescribed(model.rest()) + [
        "*STEP", "*FREQUENCY", str(MODES), "*END STEP"]
    omega2 = eigenvalues(run_ccx(folder, "rest", modes))
    return {"drive_stiffness": model.named(stiffness), "support_stiffness": supports,
            "frequencies": (np.sqrt(omega2[:MODES]) / (2 * np.pi)).tolist()}


def geometric_terms(model, displaced, forces):
    """{(body, group), (body, group): 3 x 3}, groups "u" and "r": what perturbation steps leave out.

    Of each rigid body the second derivative of its rows, sym(sum f p^T) - (sum f.p) 1 with the
    nodal forces f and arms p. Of a drive along an axis b that turns with the second of two bodies
    (here it does not) that of the stroke, b.d, times its force."""
    terms = {}
    for name, (reference, rotation) in model.handles.items():
        turn = rotation_matrix(displaced[rotation])
        moments = np.zeros((3, 3))
        for n in model.on[name]:
            moments += np.outer(forces[n], turn @ (model.nodes[n] - model.nodes[reference]))
        terms[(name, "r"), (name, "r")] = 0.5 * (moments + moments.T) - np.trace(moments) * np.eye(3)
    for first, second, node, other, own, dof in model.relative:
        force, b = forces[own][dof - 1], np.eye(3)[dof - 1]
        d = model.nodes[node] + displaced[node] - model.nodes[other] - displaced[other]
        outer = np.outer(d, b)
        terms[(second, "r"), (second, "r")] += -force * (0.5 * (outer + outer.T) - (b @ d) * np.eye(3))
        terms[(second, "r"), (first, "u")] = -force * hat(b)
        terms[(second, "r"), (second, "u")] = force * hat(b)
        for to in ((first, "u"), (second, "u")):
            terms[to, (second, "r")] = terms[(second, "r"), to].T
    return terms


def supports_at(model, folder, step, displaced, forces):
    """Support stiffnesses and frequencies about the state of a step, by perturbation."""
    turns = {b: spin_of_rate(displaced[rotation]) for b, (_, rotation) in model.handles.items()}
    terms = geometric_terms(model, displaced, forces)
    motions = model.motions()

    def moved_by(load):
        shutil.copy(os.path.join(folder, "path.rout"), os.path.join(folder, "unit.rin"))
        dat = run_ccx(folder, "unit", [
            f"*RESTART, READ, STEP={step}", "*STEP, PERTURBATION", "*STATIC", "*CLOAD, OP=NEW",
            load, "*NODE PRINT, NSET=O", "U", "*END STEP"])
        return tables(dat)[0][1]

    # one run each: a step would go on from the one before. Strokes between bodies count once more
    # in such a step, so that what no load does is taken away.
    nothing = moved_by(f"{model.handles['end_effector'][0]}, 1, 0.")
    printed = []
    for body, d in motions:
        node, dof = model.degree(body, d)
        with_load = moved_by(f"{node}, {dof}, {SIZES[d[0]]}")
        printed.append({n: u - nothing[n] for n, u in with_load.items()})

    def answers(of):
        """Motions of a printed state, turns as spins."""
        result = []
        for body, d in motions:
            node, dof = model.degree(body, d)
            result.append(of[node][dof - 1] if d[0] == "u" else
                          (turns[body] @ of[model.handles[body][1]])[dof - 1])
        return np.array(result)

    compliance = np.array([answers(of) / SIZES[d[0]] for (_, d), of in zip(motions, printed)]).T
    # loads on rotation vectors to moments; a load that a drive or a held direction bears is none
    turned = np.eye(len(motions))
    for i, (body, d) in enumerate(motions):
        for j, (other, e) in enumerate(motions):
            if body == other and d[0] == e[0] == "r":
                turned[i, j] = turns[body]["xyz".index(d[1]), "xyz".index(e[1])]
    compliance = compliance @ turned.T
    g = np.zeros((len(motions), len(motions)))
    for i, (body, d) in enumerate(motions):
        for j, (other, e) in enumerate(motions):
            term = terms.get(((body, d[0]), (other, e[0])))
            if term is not None:
                g[i, j] = term["xyz".index(d[1]), "xyz".index(e[1])]
    asymmetry = np.abs(compliance - compliance.T).max() / np.abs(compliance).max()
    stiffness = np.linalg.inv(compliance)
    exact = np.linalg.inv(0.5 * (stiffness + stiffness.T) + g)
    own = [(k, d) for k, (b, d) in enumerate(motions) if b == "end_effector"]
    shutil.copy(os.path.join(folder, "path.rout"), os.path.join(folder, "modes.rin"))
    dat = run_ccx(folder, "modes", [f"*RESTART, READ, STEP={step}", "*STEP, PERTURBATION",
                                    "*FREQUENCY", str(2 * MODES), "*NODE PRINT, NSET=O", "U",
                                    "*END STEP"])
    omega2 = eigenvalues(dat)
    shapes = np.array([answers(t[1]) for t in tables(dat)]).T
    corrected = np.linalg.eigvalsh(np.diag(omega2) + shapes.T @ g @ shapes)[:MODES]
    return {"support_stiffness": {d: float(1 / exact[k, k]) for k, d in own},
            "frequencies": (np.sqrt(corrected) / (2 * np.pi)).tolist(),
            "checks": {"asymmetry": float(asymmetry),
                       "rigid_body_term_in_compliance":
                           float(max(abs(exact[k, k] / compliance[k, k] - 1) for k, _ in own))}}


def solve(name, flexopt, folder, mesh, with_strokes, with_supports):
    """CalculiX's answers."""
    design = expanded(flexopt, job_of(name), folder)
    strokes = [p["stroke"] for p in run_flexopt(flexopt, name, "full", folder)]
    if not with_strokes:
        strokes = strokes[:1]
    model = Mechanism(design, mesh, job_of(name))
    path = [{"stroke": strokes[0], **at_rest(model, folder)}]
    lines = model.header()
    for stroke in strokes[1:]:
        lines += ["*STEP, NLGEOM, INC=200", "*RESTART, WRITE", "*CONTROLS, PARAMETERS=FIELD",
                  "1e-5, 1e-4", "*STATIC", "0.25, 1., 1e-6, 0.25", *model.prescribed(stroke),
                  "*NODE PRINT, NSET=O, FREQUENCY=1000", "U, RF"]
        for index in range(1, len(model.on) + 1):
            lines += [f"*NODE PRINT, NSET=BODY{index}, FREQUENCY=1000", "RF"]
        lines += ["*END STEP"]
    if len(strokes) > 1:
        printed = [t[1] for t in tables(run_ccx(folder, "path", lines))]
    count = 2 + len(model.on)
    for step, stroke in enumerate(strokes[1:], 1):
        at, force, *of_bodies = printed[count * (step - 1):count * step]
        reference, rotation = model.handles["end_effector"]
        point = {"stroke": stroke,
                 "drive_load": model.named(float(force[node][dof - 1])
                                           for _, node, dof in model.drives),
                 "displacement": at[reference].tolist(), "rotation": at[rotation].tolist()}
        if with_supports and stroke == strokes[-1]:
            forces = {n: f for of in [force, *of_bodies] for n, f in of.items()}
            point.update(supports_at(model, folder, step, at, forces))
        path.append(point)
    return {"job": job_of(name), "mesh": [mesh.along, mesh.across, mesh.through],
            "unknowns": 3 * len(model.nodes), "path": path}


def run_flexopt(program, name, accuracy, folder):
    job = job_of(name)
    job["model"] = {**job.get("model", {}), "accuracy": accuracy}
    return path_of(program, job, os.path.join(folder, accuracy))


def percent(a, b):
    if isinstance(a, dict):
        return ", ".join(percent(a[k], b[k]) for k in a)
    return f"{100 * (a / b - 1):+.2f}"


def row(name, accuracy, ours, solid):
    """One line of the table: stiffness of the drive at rest, its load at a stroke."""
    load = percent(ours["drive_load"], solid["drive_load"]) if "drive_load" in solid else percent(
        ours["drive_stiffness"], solid["drive_stiffness"])
    stroke = ours["stroke"]
    at = ", ".join(f"{v:g}" for v in stroke.values()) if isinstance(stroke, dict) else f"{stroke:g}"
    stiffness = solid.get("support_stiffness", {})
    cells = [percent(ours["support_stiffness"][d], stiffness[d]) if d in stiffness else ""
             for d in DIRECTIONS]
    modes = ", ".join(percent(a, b) for a, b in zip(ours["frequencies"]["drive_locked"],
                                                    solid.get("frequencies", [])))
    return f"| {name} | {accuracy} | {at} | {load} | " + " | ".join(cells) + f" | {modes} |"


def main():
    parser = parser_of(__doc__, [*CASES, *GALLERY])
    parser.add_argument("--rest", action="store_true", help="linear steps at rest alone")
    parser.add_argument("--supports", action="store_true",
                        help="stiffnesses and frequencies at the last stroke too")
    options = parser.parse_args()
    stored = stored_numbers(options, {})
    print("Differences in percent, flexopt less CalculiX.\n")
    print("| case | accuracy | stroke | drive | " + " | ".join(DIRECTIONS) + " | f1 … f6 |")
    print("|---|---|---|---|" + "---|" * 7, flush=True)
    for name in options.case or [*CASES, *GALLERY]:
        folder = os.path.join(options.work, name)
        mesh = Mesh(*options.mesh) if options.mesh else (
            CASES[name][3] if name in CASES else GALLERY[name])
        if not options.reuse:
            stored[name] = solve(name, options.flexopt, folder, mesh, not options.rest,
                                 options.supports)
        for accuracy in ("full", "reduced"):
            ours = run_flexopt(options.flexopt, name, accuracy, folder)
            for p, q in zip(ours, stored[name]["path"]):
                print(row(name, accuracy, p, q), flush=True)
        store(options, stored)


if __name__ == "__main__":
    main()
