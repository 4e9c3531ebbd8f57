#!/usr/bin/env python3
"""Draws docs/families.png: the families at their defaults, as `flexopt expand` prints them.

    docs/families.py build/release/flexopt docs/families.png

Needs Debian's python3-matplotlib.
"""
import json
import math
import subprocess
import sys
import tempfile

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection


def families(program):
    text = subprocess.run([program, "designs"], check=True, capture_output=True, text=True).stdout
    lines = text.split("Materials:")[0].splitlines()[1:]
    return [line.split()[0] for line in lines if line.strip()]


def flat(program, family):
    text = subprocess.run([program, "designs", "--export", family], check=True,
                          capture_output=True, text=True).stdout
    parameters = {name: p["example"] for name, p in json.loads(text)["parameters"].items()
                  if "default" not in p}
    drives = json.loads(text).get("drives")
    stroke = {"at": [{drives[0]["name"]: 0}]} if drives else {"at": [0]}
    wires = all("diameter" in leaf for leaf in json.loads(text)["leaves"])
    job = {"flexopt": 1, "design": {"family": family, "parameters": parameters,
                                    "material": "stavax"}, "stroke": stroke,
           "model": {"flexure": "beam" if wires else "plate"}}
    with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        json.dump(job, file)
        file.flush()
        return json.loads(subprocess.run([program, "expand", file.name], check=True,
                                         capture_output=True, text=True).stdout)


def width_at(leaf, end):
    width = leaf["width"]
    return width[end] if isinstance(width, list) else width


def middle_line(leaf, base, tip, normal):
    """Places along the leaf: an arc bulges to the normal."""
    angle = leaf.get("curve", {}).get("angle", 0)
    if not angle:
        return np.array([base, tip])
    part = np.linspace(0, 1, 25)
    radius = np.linalg.norm(tip - base) / (2 * math.sin(angle / 2))
    direction = angle * (0.5 - part)
    along = radius * (math.sin(angle / 2) - np.sin(direction))
    above = radius * (np.cos(direction) - math.cos(angle / 2))
    line = (tip - base) / np.linalg.norm(tip - base)
    return base + np.outer(along, line) + np.outer(above, normal)


def draw(axes, design):
    points = []
    for leaf in design["leaves"]:
        base, tip = np.array(leaf["base"]["at"]), np.array(leaf["tip"]["at"])
        if "diameter" in leaf and "curve" not in leaf:
            axes.plot(*np.array([base, tip]).T, color="tab:blue", linewidth=1.5)
            points += [base, tip]
            continue
        line = (tip - base) / np.linalg.norm(tip - base)
        across = np.array(leaf["across"], float)
        across -= line * across.dot(line)
        across /= np.linalg.norm(across)
        middle = middle_line(leaf, base, tip, np.cross(across, line))
        if "diameter" in leaf:
            axes.plot(*middle.T, color="tab:blue", linewidth=1.5)
            points += list(middle)
            continue
        a, b = across * width_at(leaf, 0) / 2, across * width_at(leaf, 1) / 2
        part = np.linspace(0, 1, len(middle))[:, None]
        side = a + (b - a) * part
        corners = [*(middle - side), *(middle + side)[::-1]]
        cells = [[(middle - side)[i], (middle + side)[i], (middle + side)[i + 1], (middle - side)[i + 1]]
                 for i in range(len(middle) - 1)]
        axes.add_collection3d(Poly3DCollection(cells, facecolor="tab:blue", alpha=0.45,
                                               edgecolor="none"))
        outline = np.array([*corners, corners[0]])
        axes.plot(*outline.T, color="navy", linewidth=0.6)
        for end, edge in (("base", [base - a, base + a]), ("tip", [tip - b, tip + b])):
            body = leaf[end].get("body")
            color = {"ground": "black", "end_effector": "tab:red"}.get(body, "tab:green")
            if body:
                axes.plot(*np.array(edge).T, color=color, linewidth=2)
        points += corners
    place = next(b for b in design["bodies"] if b["name"] == "end_effector")
    o = np.array(place.get("at") or place["on"]["at"])
    axes.scatter(*o, color="tab:red", s=18)
    points = np.array(points + [o])
    middle, half = (points.max(0) + points.min(0)) / 2, (points.max(0) - points.min(0)).max() / 2
    for k, set_limits in enumerate((axes.set_xlim, axes.set_ylim, axes.set_zlim)):
        set_limits(middle[k] - half, middle[k] + half)


def main():
    program, picture = sys.argv[1:]
    names = families(program)
    columns = 6
    rows = math.ceil(len(names) / columns)
    figure = plt.figure(figsize=(2.6 * columns, 2.6 * rows))
    for i, name in enumerate(names, 1):
        axes = figure.add_subplot(rows, columns, i, projection="3d", proj_type="ortho")
        draw(axes, flat(program, name))
        axes.set_axis_off()
        axes.view_init(elev=28, azim=-62, vertical_axis="z")
        axes.set_title(name, fontsize=9, y=0.95)
    figure.subplots_adjust(left=0, right=1, bottom=0, top=0.97, wspace=0, hspace=0.08)
    figure.savefig(picture, dpi=80)


if __name__ == "__main__":
    main()
