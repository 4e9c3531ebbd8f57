"""Leaf mechanisms in C3D20R solids for CalculiX: geometry, mesh, input decks, results.

Frames as everywhere in flexopt: x from base to end-effector, z along the leaves' width, O the
end-effector's reference point. SI units.
"""
import os
import subprocess
from dataclasses import dataclass, replace

import numpy as np

REFERENCE, ROTATION = 1, 2  # node numbers of the rigid end-effector: O and its rotation vector
FIRST_MASS = 3              # six point masses, then the nodes of the leaves
# Nodes of a C3D20 in half elements: corners 1-8, then mid-sides 9-20.
ORDER = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2),
         (1, 0, 0), (2, 1, 0), (1, 2, 0), (0, 1, 0), (1, 0, 2), (2, 1, 2), (1, 2, 2), (0, 1, 2),
         (0, 0, 1), (2, 0, 1), (2, 2, 1), (0, 2, 1)]


@dataclass
class Leaf:
    base: tuple
    tip: tuple
    width: float                    # at the base
    across: tuple = (0.0, 0.0, 1.0)  # direction of the width
    tip_width: float = None          # another one at the tip, linear between
    curve: float = 0.0               # angle of the arc, bulging to across x (base -> tip) [rad]
    corner: bool = False             # beside a fold, where stress goes through the thickness


@dataclass
class Folded:
    legs: list                      # two of Leaf, the second from the fold on


@dataclass
class Case:
    name: str
    thickness: float
    leaves: list
    reference: tuple      # O
    drive: int            # 1 = uy, 5 = rz
    strokes: list
    mass: float
    inertia: float        # the same about every axis
    flexopt: dict         # the design of the flexopt job
    youngs_modulus: float = 200e9
    poissons_ratio: float = 0.3
    density: float = 7800.0
    steps_per_stroke: int = 4


@dataclass
class Mesh:
    along: int = 24
    across: int = 14
    through: int = 2
    grade: float = 0.7    # x = L(xi - g sin(2 pi xi)/(2 pi)): fine at clamps and at free edges


def graded(count, grade):
    """Corner and mid-side positions in [0, 1]; mid-sides in the middle of their element."""
    xi = np.linspace(0.0, 1.0, count + 1)
    corners = xi - grade * np.sin(2 * np.pi * xi) / (2 * np.pi)
    points = np.empty(2 * count + 1)
    points[::2] = corners
    points[1::2] = 0.5 * (corners[1:] + corners[:-1])
    return points


def mesh_leaf(leaf, thickness, mesh, first_node, skew=(0.0, 0.0)):
    """Nodes {number: xyz}, elements (20 nodes each), base and tip node lists, local axes.

    skew: how far the faces at base and tip of a flat leaf lean along it, over the thickness.
    """
    base, tip = np.array(leaf.base), np.array(leaf.tip)
    along = tip - base
    length = np.linalg.norm(along)
    ex = along / length
    ez = np.array(leaf.across) - ex * np.dot(ex, leaf.across)
    ez /= np.linalg.norm(ez)
    ey = np.cross(ez, ex)
    xs = graded(mesh.along, mesh.grade) * length
    zs = graded(mesh.across, mesh.grade) - 0.5
    ys = (np.linspace(0, 1, 2 * mesh.through + 1) - 0.5) * thickness

    lean = np.zeros(len(xs))
    for end, by in enumerate(skew):
        if by:
            xs, lean = corner_lines(xs, thickness, by, end)

    tip_width = leaf.width if leaf.tip_width is None else leaf.tip_width
    widths = leaf.width + (tip_width - leaf.width) * xs / length

    def place(i, y):
        if not leaf.curve:
            return base + ex * (xs[i] + lean[i] * y) + ey * y
        angle = leaf.curve / 2 - leaf.curve * xs[i] / length  # direction of the arc
        radius = length / (2 * np.sin(leaf.curve / 2))
        middle = base + ex * length / 2 - ey * radius * np.cos(leaf.curve / 2)
        return middle + (radius + y) * (ey * np.cos(angle) - ex * np.sin(angle))

    number, nodes = {}, {}
    for i in range(len(xs)):
        for j in range(len(ys)):
            for k in range(len(zs)):
                if (i % 2) + (j % 2) + (k % 2) > 1:
                    continue  # serendipity: corners and mid-sides only
                n = first_node + len(nodes)
                number[i, j, k] = n
                nodes[n] = place(i, ys[j]) + ez * zs[k] * widths[i]
    elements = [[number[2 * i + a, 2 * j + b, 2 * k + c] for a, b, c in ORDER]
                for i in range(len(xs) // 2) for j in range(mesh.through)
                for k in range(mesh.across)]
    ends = [[n for (i, j, k), n in number.items() if i == end] for end in (0, len(xs) - 1)]
    return nodes, elements, ends[0], ends[1], (ex, ey, ez)


def corner_lines(xs, thickness, skew, end):
    """Lines of a leg whose face at the base (end 0) or tip (1) is mitred, and how far each leans.

    Near the corner elements are a quarter of the thickness long, beyond 2 t each next one half as
    long again, until those of the leg are as short. Lines lean less and less over 2 t.
    """
    length = xs[-1]
    corners = xs[::2] if end == 0 else length - xs[::-2]
    places, step = [0.0], thickness / 4
    while True:
        rest = corners[corners > places[-1] + 0.5 * step]
        if places[-1] > 3 * thickness and rest[0] - places[-1] < 1.5 * step:
            break
        places.append(places[-1] + step)
        if places[-1] > 2 * thickness:
            step *= 1.5
    places = np.concatenate([places, rest])
    every = np.empty(2 * len(places) - 1)
    every[::2] = places
    every[1::2] = 0.5 * (places[1:] + places[:-1])
    lean = np.interp(places, [0, 2 * thickness * max(1, abs(skew))], [skew, 0.0])
    lean = np.interp(every, places, lean)
    return (every, lean) if end == 0 else (length - every[::-1], lean[::-1])


def mesh_folded(legs, thickness, mesh, first_node):
    """Two legs that share the nodes of a mitred face: nodes, parts (cells, axes, leaf), base and tip
    nodes. Of each leg what is nearer to the fold than 2 t, or the mitre leans, is a part."""
    def normal(leg):
        along = np.array(leg.tip) - np.array(leg.base)
        along = along / np.linalg.norm(along)
        return along, np.cross(np.array(leg.across) / np.linalg.norm(leg.across), along)

    (x1, y1), (x2, y2) = normal(legs[0]), normal(legs[1])
    mitre = (y1 + y2) / (1 + y1 @ y2)
    first = mesh_leaf(legs[0], thickness, mesh, first_node, (0.0, mitre @ x1))
    second = mesh_leaf(legs[1], thickness, mesh, first_node + len(first[0]), (mitre @ x2, 0.0))
    shared = dict(zip(second[2], first[3]))
    for own, other in shared.items():
        assert np.linalg.norm(second[0][own] - first[0][other]) < 1e-9 * thickness + 1e-12
    # without holes in the numbers
    keep = {n: first_node + len(first[0]) + k
            for k, n in enumerate(n for n in second[0] if n not in shared)}
    number = {**keep, **shared}
    nodes = {**first[0], **{keep[n]: p for n, p in second[0].items() if n in keep}}
    cells = [[number[n] for n in cell] for cell in second[1]]
    parts, reach = [], 2 * thickness * max(1, abs(mitre @ x1))
    for leg, axes, own in ((legs[0], first[4], first[1]), (legs[1], second[4], cells)):
        fold = np.array(legs[0].tip)
        near = [abs(np.mean([nodes[n] - fold for n in cell], axis=0) @ axes[0]) < reach
                for cell in own]
        for corner in (False, True):
            parts.append(([c for c, at in zip(own, near) if at == corner], axes,
                          replace(leg, corner=corner)))
    return nodes, parts, first[2], [number[n] for n in second[3]]


@dataclass
class Wire:
    base: tuple
    tip: tuple
    diameter: float
    across: tuple
    curve: float = 0.0


def mesh_disk():
    """Quadratic quadrilaterals on the unit disk: four in a square, eight around them. Places of the
    nodes, and the cells with their four corners before their mid-sides."""
    a = 0.45
    rim = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)]
    inner = [a * np.array(p, float) for p in rim]
    outer = [np.array(p) / np.hypot(*p) for p in rim]
    quads = [[np.zeros(2), inner[k], inner[(k + 1) % 8], inner[(k + 2) % 8]] for k in (0, 2, 4, 6)]
    quads += [[inner[k], outer[k], outer[(k + 1) % 8], inner[(k + 1) % 8]] for k in range(8)]
    places, cells = [], []

    def number(p):
        for k, q in enumerate(places):
            if np.linalg.norm(p - q) < 1e-9:
                return k
        places.append(p)
        return len(places) - 1

    for quad in quads:
        middles = []
        for k in range(4):
            p, q = quad[k], quad[(k + 1) % 4]
            middle = 0.5 * (p + q)
            if min(np.hypot(*p), np.hypot(*q)) > 1 - 1e-9:  # on the circle
                middle /= np.hypot(*middle)
            middles.append(middle)
        cells.append([number(p) for p in quad + middles])
    return places, cells


def mesh_wire(wire, along, grade, first_node):
    """As mesh_leaf, of a wire: 12 elements in its section."""
    base, tip = np.array(wire.base), np.array(wire.tip)
    length = np.linalg.norm(tip - base)
    ex = (tip - base) / length
    ez = np.array(wire.across) - ex * np.dot(ex, wire.across)
    ez /= np.linalg.norm(ez)
    ey = np.cross(ez, ex)
    xs = graded(along, grade) * length
    places, cells = mesh_disk()
    corners = {n for cell in cells for n in cell[:4]}
    number, nodes = {}, {}
    for i, x in enumerate(xs):
        for k, (y, z) in enumerate(places):
            if i % 2 == 0 or k in corners:
                number[i, k] = first_node + len(nodes)
                nodes[number[i, k]] = base + ex * x + wire.diameter / 2 * (ey * y + ez * z)
    elements = []
    for i in range(0, 2 * along, 2):
        for cell in cells:
            elements.append([number[i, k] for k in cell[:4]] + [number[i + 2, k] for k in cell[:4]]
                            + [number[i, k] for k in cell[4:]] + [number[i + 2, k] for k in cell[4:]]
                            + [number[i + 1, k] for k in cell[:4]])
    ends = [[n for (i, k), n in number.items() if i == end] for end in (0, len(xs) - 1)]
    return nodes, elements, ends[0], ends[1], (ex, ey, ez)


def orientation(index, leaf, axes):
    """The local axes of a leaf, and which of them stands along its thickness."""
    ex, ey, ez = axes
    if not leaf.curve:
        return [f"*ORIENTATION, NAME=AXES{index}, SYSTEM=RECTANGULAR",
                ", ".join(f"{v:.12g}" for v in (*ex, *ey))], "y"
    # local x comes from the line that the leaf is bent about
    base, tip = np.array(leaf.base), np.array(leaf.tip)
    half = np.linalg.norm(tip - base) / 2
    middle = (base + tip) / 2 - ey * half / np.tan(leaf.curve / 2)
    return [f"*ORIENTATION, NAME=AXES{index}, SYSTEM=CYLINDRICAL",
            ", ".join(f"{v:.12g}" for v in (*middle, *(middle + ez)))], "x"


def plate_material(name, e, nu, density, thickness):
    """No Poisson coupling with the thickness (local x or y): what Kirchhoff's plane stress is. None
    at all (thickness "") is that of a slender beam."""
    g = e / (2 * (1 + nu))
    ratios = {"y": f"0., {nu:.12g}, 0.", "x": f"0., 0., {nu:.12g}", "": "0., 0., 0."}[thickness]
    return [f"*MATERIAL, NAME={name}", "*ELASTIC, TYPE=ENGINEERING CONSTANTS",
            f"{e:.12g}, {e:.12g}, {e:.12g}, {ratios}, {g:.12g}, {g:.12g},",
            f"{g:.12g}, 293.", "*DENSITY", f"{density:.12g}"]


def isotropic_material(name, e, nu, density):
    return [f"*MATERIAL, NAME={name}", "*ELASTIC", f"{e:.12g}, {nu:.12g}", "*DENSITY",
            f"{density:.12g}"]


def chunks(numbers, size=12):
    return "\n".join(", ".join(str(n) for n in numbers[i:i + size]) + ","
                     for i in range(0, len(numbers), size))


def node_cards(nodes):
    return ["*NODE, NSET=NALL"] + [f"{n}, {p[0]:.12g}, {p[1]:.12g}, {p[2]:.12g}"
                                   for n, p in nodes.items()]


def solid_cards(leaves):
    """Elements and sections of (cells, axes, leaf); how many elements."""
    out, sections, element = [], [], 0
    for index, (cells, axes, leaf) in enumerate(leaves, 1):
        out.append(f"*ELEMENT, TYPE=C3D20R, ELSET=LEAF{index}")
        for element, cell in enumerate(cells, element + 1):
            out.append(f"{element}, " + ", ".join(map(str, cell[:15])) + ",")
            out.append(", ".join(map(str, cell[15:])))
        lines, thickness = orientation(index, leaf, axes)
        out += lines
        material = ("WIRE" if isinstance(leaf, Wire) else "CORNER" if leaf.corner
                    else {"x": "ARC", "y": "FLAT"}[thickness])
        sections.append(f"*SOLID SECTION, ELSET=LEAF{index}, MATERIAL={material}, "
                        f"ORIENTATION=AXES{index}")
    return out, sections, element


class Model:
    """The mesh of a case and what every deck of it shares."""

    def __init__(self, case, mesh):
        self.case = case
        self.nodes = {REFERENCE: np.array(case.reference), ROTATION: np.array(case.reference)}
        self.masses, self.base, self.tip = [], [], []
        self.leaves = []  # (cells, axes, leaf) of every leaf, or part of one
        # Six equal masses at +-a on the axes: inertia (m/6) 4 a^2 about every axis.
        arm = (1.5 * case.inertia / case.mass) ** 0.5
        for axis in range(3):
            for side in (1, -1):
                n = FIRST_MASS + len(self.masses)
                self.nodes[n] = np.array(case.reference) + side * arm * np.eye(3)[axis]
                self.masses.append(n)
        first = FIRST_MASS + 6
        for leaf in case.leaves:
            if isinstance(leaf, Folded):
                nodes, parts, base, tip = mesh_folded(leaf.legs, case.thickness, mesh, first)
                self.leaves += parts
            else:
                nodes, cells, base, tip, axes = mesh_leaf(leaf, case.thickness, mesh, first)
                self.leaves.append((cells, axes, leaf))
            self.nodes.update(nodes)
            self.base += base
            self.tip += tip
            first += len(nodes)
        self.unknowns = 3 * len(self.nodes)

    def header(self):
        c = self.case
        solids, sections, elements = solid_cards(self.leaves)
        out = node_cards(self.nodes) + solids + ["*ELEMENT, TYPE=MASS, ELSET=POINTS"]
        out += [f"{elements + i}, {n}" for i, n in enumerate(self.masses, 1)]
        out += ["*MASS, ELSET=POINTS", f"{c.mass / 6:.12g}"]
        e, nu = c.youngs_modulus, c.poissons_ratio
        for name, thickness in (("FLAT", "y"), ("ARC", "x")):
            out += plate_material(name, e, nu, c.density, thickness)
        out += isotropic_material("CORNER", e, nu, c.density)
        out += sections
        out += ["*NSET, NSET=BASE", chunks(self.base), "*NSET, NSET=TIP", chunks(self.tip),
                "*NSET, NSET=BODY", chunks(self.tip + self.masses),
                f"*NSET, NSET=O\n{REFERENCE}, {ROTATION},",
                f"*RIGID BODY, NSET=BODY, REF NODE={REFERENCE}, ROT NODE={ROTATION}",
                "*BOUNDARY", "BASE, 1, 3, 0."]
        return out

    def first_steps(self):
        """What comes before the strokes; prints nothing."""
        return []

    def held(self):
        return ((REFERENCE, self.case.drive + 1) if self.case.drive < 3
                else (ROTATION, self.case.drive - 2))

    def stroke_step(self, stroke, increments):
        node, dof = self.held()
        return ["*STEP, NLGEOM, INC=200", "*RESTART, WRITE",
                "*CONTROLS, PARAMETERS=FIELD", "1e-5, 1e-4", "*STATIC",
                f"{1 / increments:.12g}, 1., 1e-6, {1 / increments:.12g}",
                "*BOUNDARY", f"{node}, {dof}, {dof}, {stroke:.12g}",
                "*NODE PRINT, NSET=O, FREQUENCY=1000", "U",
                "*NODE PRINT, NSET=TIP, FREQUENCY=1000", "U, RF",
                "*END STEP"]


def run_ccx(folder, name, lines):
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(folder, name + ".inp"), "w") as file:
        file.write("\n".join(lines) + "\n")
    environment = dict(os.environ, OMP_NUM_THREADS="1")
    with open(os.path.join(folder, name + ".log"), "w") as log:
        subprocess.run(["ccx", name], cwd=folder, env=environment, stdout=log,
                       stderr=subprocess.STDOUT, check=True)
    with open(os.path.join(folder, name + ".dat")) as file:
        return file.read()
