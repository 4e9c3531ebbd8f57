#!/usr/bin/python3
"""Draws support_stiffness.png, the picture of README.md: a three-flexure cross hinge turned by 20°
either way, its support stiffness and frequencies over that turn, computed by the job of the gallery.

    docs/support_stiffness.py build/release/flexopt

Needs Debian's package python3-matplotlib.
"""
import csv
import math
import pathlib
import subprocess
import sys
import tempfile

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot

HERE = pathlib.Path(__file__).resolve().parent
JOB = HERE.parent / "designs/jobs/three_flexure_cross_hinge.json"


def path_of(program):
    """Columns of path.csv by name, units left out."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([program, "run", str(JOB), "--quiet", "--out", folder,
                        "--set", '/job="evaluate"', "--set", "/expect=[]",
                        "--set", '/stroke/from="-20 deg"', "--set", "/stroke/points=81"],
                       check=True, stdout=subprocess.DEVNULL)
        with open(pathlib.Path(folder) / "path.csv", newline="") as file:
            rows = list(csv.DictReader(file))
    return {key.split(" [")[0]: [float(row[key] or "nan") for row in rows] for key in rows[0]
            if key.split(" [")[0] == "stroke" or key.startswith(("support_", "frequencies."))}


def main():
    path = path_of(sys.argv[1])
    angle = [math.degrees(s) for s in path["stroke"]]
    figure, panels = pyplot.subplots(1, 3, figsize=(10.4, 3.2), layout="constrained")
    for panel, title, columns in zip(
            panels,
            ("support stiffness [N/m]", "support stiffness [N m/rad]",
             "natural frequencies, drive held [Hz]"),
            ({d: f"support_stiffness.{d}" for d in ("ux", "uy", "uz")},
             {d: f"support_stiffness.{d}" for d in ("rx", "ry")},
             {f"mode {k + 1}": f"frequencies.drive_locked.{k}" for k in range(3)})):
        for name, column in columns.items():
            panel.plot(angle, path[column], label=name)
        panel.set_title(title, fontsize="medium")
        panel.set_xlabel("turn of the hinge [deg]")
        panel.set_xlim(-20, 20)
        panel.grid(alpha=0.3)
        panel.legend()
    for panel in panels[:2]:
        panel.set_yscale("log")
    panels[2].set_ylim(bottom=0)
    figure.savefig(HERE / "support_stiffness.png", dpi=110, metadata={"Software": None})


if __name__ == "__main__":
    main()
