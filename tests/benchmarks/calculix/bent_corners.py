#!/usr/bin/env python3
"""Folded leaves whose corner is bent about an inner radius, in solid elements, against flexopt. See
README.md, "Corners of folds".

bent_corners.py --flexopt build/release/flexopt --work /tmp/calculix [--case NAME] [--radius R]...
"""
import copy
import dataclasses
import math
import os

import numpy as np

from make_and_compare import CASES, differences, print_table, record, run_flexopt, solve_case
from program import parser_of, store, stored_numbers
from solid_model import FIRST_MASS, ORDER, Leaf, Mesh, Model, graded

FOLDS = [name for name in CASES if "fold" in name]
Z = np.array([0.0, 0.0, 1.0])


def lines_to_arc(length, thickness, mesh):
    """Places from a clamp to the arc: elements of t/3 beside the arc, longer away from it until
    those of the graded mesh are as short."""
    back = np.sort(length - graded(mesh.along, mesh.grade)[::2] * length)
    places, step = [0.0], thickness / 3
    while True:
        rest = back[back > places[-1] + 0.5 * step]
        if places[-1] > 2 * thickness and rest[0] - places[-1] < 1.5 * step:
            break
        places.append(places[-1] + step)
        if places[-1] > thickness:
            step *= 1.5
    return length - np.concatenate([places, rest])[::-1]


class BentModel(Model):
    """The first leg along x, an arc about z, the second leg; the lines on which the legs meet are
    those of the case."""

    def __init__(self, case, mesh, radius):
        super().__init__(dataclasses.replace(case, leaves=[]), mesh)
        self.case = case
        first, second = case.leaves[0].legs
        t, width, corner = case.thickness, first.width, np.array(first.tip)
        along = np.array(second.tip) - corner
        self.turn, middle_radius = math.atan2(along[1], along[0]), radius + t / 2
        cut = middle_radius * math.tan(self.turn / 2)
        self.arc_start = corner - [cut, 0, 0]
        self.centre = self.arc_start + [0, middle_radius, 0]
        self.radius, self.along = middle_radius, along / np.linalg.norm(along)
        self.across_second = np.cross(Z, self.along)
        self.arc_end = corner + cut * self.along
        count = max(4, math.ceil(middle_radius * self.turn / (t / 3)))
        to_arc = lines_to_arc(self.arc_start[0], t, mesh)
        length = np.linalg.norm(along) - cut
        from_arc = length - lines_to_arc(length, t, mesh)[::-1]
        angles = np.linspace(0, self.turn, count + 1)
        self.lines = ([("first", x) for x in to_arc[:-1]] + [("arc", a) for a in angles[:-1]]
                      + [("second", x) for x in from_arc])
        self.ends = {"first": to_arc[-1], "arc": self.turn}
        self.add_solids(mesh, t, width)
        chord = self.arc_end - self.arc_start
        chord /= np.linalg.norm(chord)
        x, y = np.array([1.0, 0, 0]), np.array([0, 1.0, 0])
        first_leg = Leaf(first.base, tuple(self.arc_start), width)
        second_leg = Leaf(tuple(self.arc_end), second.tip, width)
        arc = Leaf(tuple(self.arc_start), tuple(self.arc_end), width, curve=-self.turn, corner=True)
        self.leaves = [(self.cells["arc"], (chord, np.cross(Z, chord), Z), arc)]
        # the legs beside the arc belong to the corner
        for leg, part, axes, at in ((first_leg, "first", (x, y, Z), self.arc_start),
                                    (second_leg, "second",
                                     (self.along, self.across_second, Z), self.arc_end)):
            near = [abs((np.mean([self.nodes[n] for n in cell], axis=0) - at) @ axes[0]) < 1.5 * t
                    for cell in self.cells[part]]
            for corner in (False, True):
                self.leaves.append(([c for c, at in zip(self.cells[part], near) if at == corner],
                                    axes, dataclasses.replace(leg, corner=corner)))
        self.unknowns = 3 * len(self.nodes)

    def line(self, i):
        """Of corner nodes (i even) and mid-sides: the part, and the place in it."""
        part, at = self.lines[i // 2]
        if i % 2 == 0:
            return part, at
        next_part, following = self.lines[i // 2 + 1]
        return part, 0.5 * (at + (following if next_part == part else self.ends[part]))

    def place(self, i, y):
        part, at = self.line(i)
        if part == "first":
            return np.array([at, y, 0])
        if part == "arc":
            return self.centre + (self.radius - y) * np.array([math.sin(at), -math.cos(at), 0])
        return self.arc_end + self.along * at + self.across_second * y

    def add_solids(self, mesh, thickness, width):
        zs = (graded(mesh.across, mesh.grade) - 0.5) * width
        ys = (np.linspace(0, 1, 2 * mesh.through + 1) - 0.5) * thickness
        last, number = 2 * len(self.lines) - 2, {}
        for i in range(last + 1):
            for j, y in enumerate(ys):
                for k, z in enumerate(zs):
                    if (i % 2) + (j % 2) + (k % 2) > 1:
                        continue
                    number[i, j, k] = FIRST_MASS + 6 + len(number)
                    self.nodes[number[i, j, k]] = self.place(i, y) + z * Z
        self.cells = {"first": [], "arc": [], "second": []}
        for i in range(len(self.lines) - 1):
            for j in range(mesh.through):
                for k in range(mesh.across):
                    self.cells[self.lines[i][0]].append(
                        [number[2 * i + a, 2 * j + b, 2 * k + c] for a, b, c in ORDER])
        self.base = [n for (i, _, _), n in number.items() if i == 0]
        self.tip = [n for (i, _, _), n in number.items() if i == last]


def with_radius(case, radius):
    """The case with a bent corner in flexopt too."""
    flexopt = copy.deepcopy(case.flexopt)
    if "family" in flexopt:
        flexopt["parameters"]["fold_radius"] = radius
    else:
        flexopt["mechanism"]["leaves"][0]["fold"]["radius"] = radius
    return dataclasses.replace(case, flexopt=flexopt)


def main():
    parser = parser_of(__doc__, FOLDS)
    parser.add_argument("--radius", type=float, action="append", help="inner, over the thickness")
    options = parser.parse_args()
    stored = stored_numbers(options, {"cases": {}})
    for name in options.case or FOLDS:
        case = CASES[name][0]
        case = dataclasses.replace(case, strokes=case.strokes[:1], steps_per_stroke=1)
        folder = os.path.join(options.work, "bent_" + name)
        for ratio in options.radius or [0.5, 1, 2]:
            bent, title = with_radius(case, ratio * case.thickness), f"{name}, r = {ratio:g} t"
            ours = run_flexopt(options.flexopt, bent, {"accuracy": "reduced"},
                               os.path.join(folder, "flexopt"))
            if options.reuse:
                solid = stored["cases"][title]
            else:
                solid = solve_case(case, Mesh(*(options.mesh or (16, 8, 2))), folder,
                                   make_model=lambda *a: BentModel(*a, ratio * case.thickness))
            stored["cases"][title] = record(bent, solid)
            store(options, stored)
            print_table(title, case, case.strokes,
                        differences(case, ours, solid["path"]))


if __name__ == "__main__":
    main()
