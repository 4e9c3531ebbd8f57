#!/usr/bin/env python3
"""What the corner of a fold takes from both legs, of plane elasticity and of torsion. See README.md,
"Corners of folds". Lengths in thicknesses.

corner_in_plane.py [--turn DEG]... [--radius R]... [--material isotropic|plate] [--fine N]

Needs python3-scipy. One leg up to the plane of symmetry, eight-node quadrilaterals.
"""
import argparse
import math

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import spsolve

CORNERS = [(-1, -1), (1, -1), (1, 1), (-1, 1), (0, -1), (1, 0), (0, 1), (-1, 0)]
GAUSS = list(zip((-math.sqrt(0.6), 0.0, math.sqrt(0.6)), (5 / 9, 8 / 9, 5 / 9)))
POISSON = 0.3
STRAIGHT = 4.0  # of the leg beyond the corner


def functions(x, y):
    """Values and slopes of the eight functions."""
    n, dx, dy = np.empty(8), np.empty(8), np.empty(8)
    for k, (a, b) in enumerate(CORNERS):
        if a and b:
            n[k] = 0.25 * (1 + a * x) * (1 + b * y) * (a * x + b * y - 1)
            dx[k] = 0.25 * a * (1 + b * y) * (2 * a * x + b * y)
            dy[k] = 0.25 * b * (1 + a * x) * (a * x + 2 * b * y)
        elif b:
            n[k] = 0.5 * (1 - x * x) * (1 + b * y)
            dx[k], dy[k] = -x * (1 + b * y), 0.5 * b * (1 - x * x)
        else:
            n[k] = 0.5 * (1 + a * x) * (1 - y * y)
            dx[k], dy[k] = 0.5 * a * (1 - y * y), -y * (1 + a * x)
    return n, dx, dy


def growing(total, first, largest, ratio):
    places, step = [0.0], first
    while places[-1] < total:
        places.append(places[-1] + step)
        step = min(step * ratio, largest)
    return np.array(places) * total / places[-1]


class Leg:
    """u along from the plane of symmetry, v across from the outer face to the inner one; the fold
    line is the origin, x runs into the leg, the inner side is y > 0."""

    def __init__(self, turn, radius, fine):
        self.half = turn / 2
        self.R, self.bent = radius + 0.5, radius > 0
        tangent = math.tan(self.half)
        if self.bent:
            self.cut = self.R * tangent
            arc, self.length = self.R * self.half, STRAIGHT + self.cut
            size = 0.05 if arc < 0.4 else 0.1
            count = max(4, math.ceil(arc / (size / fine)))
            leg = growing(STRAIGHT, min(0.05 / fine, 1.2 * arc / count), 0.2 / fine, 1.3)
            self.u = np.concatenate([np.linspace(-arc, 0, count + 1)[:-1], leg])
            side = growing(0.5, min(0.1, radius / 3) / fine / 2, 0.1 / fine, 1.4)
            self.v = np.concatenate([side, 1 - side[::-1][1:]])
        else:
            self.tangent, self.lean = tangent, max(2.0, 2 * tangent)
            self.length = self.lean + STRAIGHT
            self.u = growing(self.length, 0.002 / fine, 0.15 / fine, 1.25)
            self.v = 1 - growing(1, 0.002 / fine, 0.12 / fine, 1.35)[::-1]
        self.number, places = {}, []
        us, vs = self.with_middles(self.u), self.with_middles(self.v)
        for i, u in enumerate(us):
            for j, v in enumerate(vs):
                if i % 2 == 0 or j % 2 == 0:
                    self.number[i, j] = len(places)
                    places.append(self.place(u, v - 0.5))
        self.places, self.last, self.side = np.array(places), len(us) - 1, len(vs) - 1

    @staticmethod
    def with_middles(corners):
        every = np.empty(2 * len(corners) - 1)
        every[::2], every[1::2] = corners, 0.5 * (corners[1:] + corners[:-1])
        return every

    def place(self, u, y):
        if not self.bent:
            return [u + max(0.0, 1 - u / self.lean) * y * self.tangent, y]
        if u >= 0:
            return [self.cut + u, y]
        angle = -u / self.R
        return [self.cut - (self.R - y) * math.sin(angle), self.R - (self.R - y) * math.cos(angle)]

    def elements(self):
        """Nodes, and (weight, functions, their slopes in x and y, direction of the leg) at points."""
        at = [(wx * wy, x, functions(x, y)) for x, wx in GAUSS for y, wy in GAUSS]
        for e in range(self.last // 2):
            for f in range(self.side // 2):
                nodes = np.array([self.number[2 * e + a + 1, 2 * f + b + 1] for a, b in CORNERS])
                points = []
                for weight, x, (n, dx, dy) in at:
                    jacobian = np.array([dx, dy]) @ self.places[nodes]
                    slopes = np.linalg.solve(jacobian, np.array([dx, dy]))
                    u = self.u[e] + 0.5 * (1 + x) * (self.u[e + 1] - self.u[e])
                    turned = min(0.0, u) / self.R if self.bent else 0.0
                    points.append((weight * np.linalg.det(jacobian), n, slopes, turned))
                yield nodes, points


def elasticity(material, turned):
    """Plane strain across the width, in x and y; and E/(1 - nu^2)."""
    plate, shear = 1 / (1 - POISSON**2), 1 / (2 * (1 + POISSON))
    if material == "isotropic":
        lame = POISSON / (1 + POISSON) / (1 - 2 * POISSON)
        local = np.array([[lame + 2 * shear, lame, 0], [lame, lame + 2 * shear, 0], [0, 0, shear]])
    else:  # no Poisson coupling with the thickness
        local = np.diag([plate, 1.0, shear])
    c, s = math.cos(turned), math.sin(turned)
    to_local = np.array([[c * c, s * s, c * s], [s * s, c * c, -c * s],
                         [-2 * c * s, 2 * c * s, c * c - s * s]])
    return to_local.T @ local @ to_local, plate


def assembled(parts, size):
    rows, columns, values = [], [], []
    for where, matrix in parts:
        rows.append(np.repeat(where, len(where)))
        columns.append(np.tile(where, len(where)))
        values.append(matrix.ravel())
    join = np.concatenate
    return sparse.csr_matrix((join(values), (join(rows), join(columns))), shape=(size, size))


def bending(leg, material):
    """s: a moment 1 turns the leg by what it turns one that is shorter by this."""
    parts, size = [], 2 * len(leg.places)
    for nodes, points in leg.elements():
        matrix = np.zeros((16, 16))
        for weight, _, (dx, dy), turned in points:
            strain = np.zeros((3, 16))
            strain[0, ::2], strain[1, 1::2], strain[2, ::2], strain[2, 1::2] = dx, dy, dy, dx
            matrix += weight * strain.T @ elasticity(material, turned)[0] @ strain
        parts.append((np.stack([2 * nodes, 2 * nodes + 1], axis=1).ravel(), matrix))
    # the nodes of the plane of symmetry move along it
    turn, held = sparse.identity(size, format="lil"), []
    c, s = math.cos(leg.half), math.sin(leg.half)
    for j in range(leg.side + 1):
        k = 2 * leg.number[0, j]
        turn[k, k], turn[k + 1, k], turn[k, k + 1], turn[k + 1, k + 1] = c, -s, s, c
        held.append(k)
    held.append(2 * leg.number[0, leg.side] + 1)
    load = np.zeros(size)
    for f in range(leg.side // 2):
        low, high = leg.v[f] - 0.5, leg.v[f + 1] - 0.5
        nodes = [leg.number[leg.last, 2 * f + k] for k in range(3)]
        for z, weight in GAUSS:
            y = 0.5 * (low + high) + z * (high - low) / 2
            for n, part in zip(nodes, (z * (z - 1) / 2, 1 - z * z, z * (z + 1) / 2)):
                load[2 * n] += weight * (high - low) / 2 * 12 * y * part
    turn = turn.tocsr()
    matrix, load = (turn.T @ assembled(parts, size) @ turn).tocsc(), turn.T @ load
    free = np.setdiff1d(np.arange(size), held)
    work = load[free] @ spsolve(matrix[free][:, free], load[free])
    return leg.length - work * elasticity(material, 0.0)[1] / 12


def torsion(leg):
    """s_xy: the constant of the section, turned about the fold, is that of one that is shorter by
    this (Prandtl's stress function)."""
    parts, load = [], np.zeros(len(leg.places))
    for nodes, points in leg.elements():
        parts.append((nodes, sum(w * slopes.T @ slopes for w, _, slopes, _ in points)))
        load[nodes] += 2 * sum(w * n for w, n, _, _ in points)
    faces = [leg.number[i, j] for i in range(leg.last + 1) for j in (0, leg.side)]
    free = np.setdiff1d(np.arange(len(load)), faces)
    matrix = assembled(parts, len(load)).tocsc()[free][:, free]
    return leg.length - 3 * load[free] @ spsolve(matrix, load[free])


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--turn", type=float, action="append", help="of the fold [deg]")
    parser.add_argument("--radius", type=float, action="append", help="inner; 0: a mitred corner")
    parser.add_argument("--material", choices=["isotropic", "plate"], default="isotropic")
    parser.add_argument("--fine", type=float, default=1, help="elements so many times as short")
    options = parser.parse_args()
    for turn in options.turn or [30, 50, 90, 130]:
        for radius in options.radius or [0, 0.5, 1, 2]:
            leg = Leg(math.radians(turn), radius, options.fine)
            print(f"{turn:g} deg, r = {radius:g}: s = {bending(leg, options.material):.4f}, "
                  f"s_xy = {torsion(leg):.4f}", flush=True)


if __name__ == "__main__":
    main()
