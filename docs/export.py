#!/usr/bin/python3
"""Draws export.png, the picture of export.md, from STL files: three mechanisms of the gallery at the
ends of their strokes.

    docs/export.py build/release/flexopt

Needs Debian's package python3-matplotlib.
"""
import pathlib
import subprocess
import sys
import tempfile

import matplotlib

matplotlib.use("Agg")
import numpy as np
from matplotlib import pyplot
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

HERE = pathlib.Path(__file__).resolve().parent
JOBS = HERE.parent / "designs/jobs"
PANELS = [("cross_hinge", "20 deg", "cross hinge at 20°", (60, -60)),
          ("double_parallelogram", "10 mm", "double parallelogram at 10 mm", (55, -70)),
          ("spherical_joint", "4 deg", "spherical joint at 4°", (25, -50))]


def solids(file):
    """{name: triangles [n, 3, 3] in mm}"""
    found, name = {}, None
    for line in file.read_text().splitlines():
        words = line.split()
        if words[0] == "solid":
            name = words[1]
            found[name] = []
        elif words[0] == "vertex":
            found[name].append([float(w) for w in words[1:]])
    return {name: np.array(points).reshape(-1, 3, 3) for name, points in found.items()}


def draw(panel, parts, view):
    light = np.array([0.3, -0.4, 0.86])
    for name, triangles in parts.items():
        normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
        shade = 0.55 + 0.45 * np.abs(normals @ light)[:, None]
        body = name in ("end_effector", "stage")
        color = np.array([0.25, 0.42, 0.70] if body else [0.80, 0.82, 0.85])
        faces = np.hstack([np.clip(shade * color, 0, 1),
                           np.full((len(triangles), 1), 0.35 if body else 1.0)])
        panel.add_collection3d(Poly3DCollection(triangles, facecolors=faces, linewidths=0))
    points = np.concatenate([t.reshape(-1, 3) for t in parts.values()])
    low, high = points.min(axis=0), points.max(axis=0)
    panel.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    panel.set_box_aspect(high - low, zoom=1.08)
    panel.view_init(*view)
    panel.set_axis_off()


def main():
    figure = pyplot.figure(figsize=(10.4, 3.6))
    with tempfile.TemporaryDirectory() as folder:
        for k, (job, at, title, view) in enumerate(PANELS, 1):
            subprocess.run([sys.argv[1], "export", str(JOBS / f"{job}.json"), "--format", "stl",
                            "--at", at, "--out", folder], check=True, stdout=subprocess.DEVNULL)
            panel = figure.add_subplot(1, len(PANELS), k, projection="3d")
            draw(panel, solids(pathlib.Path(folder) / f"{job}.stl"), view)
            panel.set_title(title, fontsize=10, y=-0.02)
    figure.subplots_adjust(left=0, right=1, bottom=0.06, top=1, wspace=0)
    figure.savefig(HERE / "export.png", dpi=110)


if __name__ == "__main__":
    main()
