#!/usr/bin/env python3
"""Buckling of a parallel guide under its payload: solid elements (CalculiX, *BUCKLE) against flexopt.

buckling.py --flexopt build/release/flexopt --work /tmp/calculix [--mesh ALONG ACROSS THROUGH]

At rest, with the drive locked and free; the payload presses on O along the leaves. CalculiX gives
the linear factor about the unloaded state, flexopt the one along the equilibria: they differ by the
strain of the loaded leaves, some 1e-5. Prints a table in Markdown.
"""
import argparse
import os
import re

from make_and_compare import guide
from program import path_of
from solid_model import REFERENCE, Mesh, Model, run_ccx

LENGTHS = {"guide": (0.1, 0.03, 5e-4, 0.1), "wide short guide": (0.03, 0.06, 5e-4, 0.1)}
PAYLOAD = 100.0  # [N]


def solid_factors(folder, name, size, mesh):
    case = guide(name, *size, [0.0])
    factors = {}
    for drive in ("drive_locked", "drive_free"):
        lines = Model(case, mesh).header()
        if drive == "drive_locked":
            lines.append(f"{REFERENCE}, {case.drive + 1}, {case.drive + 1}, 0.")
        lines += ["*STEP", "*BUCKLE", "4, 1e-4", "*CLOAD", f"{REFERENCE}, 1, {-PAYLOAD}",
                  "*END STEP"]
        data = run_ccx(folder, name.replace(" ", "_") + "_" + drive, lines)
        table = data.split("F A C T O R   O U T P U T")[1]
        found = [float(m) for m in re.findall(r"^\s+\d+\s+(\S+)\s*$", table, re.M)]
        factors[drive] = min((f for f in found if f > 0), default=None)
    return factors


def own_factors(flexopt, folder, name, size):
    length, width, thickness, spacing = size
    job = {"flexopt": 1, "name": name, "job": "evaluate", "frequencies": 0,
           "design": {"family": "parallel_guide",
                      "parameters": {"length": length, "width": width, "thickness": thickness,
                                     "spacing": spacing},
                      "material": {"youngs_modulus": 200e9, "poissons_ratio": 0.3,
                                   "density": 7800.0}},
           "loads": [{"name": "payload", "force": [-PAYLOAD, 0, 0]}],
           "buckling": {"load": "payload", "largest_factor": 1e6}, "stroke": {"at": [0]}}
    return path_of(flexopt, job, os.path.join(folder, name.replace(" ", "_")))[0]["buckling"]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--flexopt")
    parser.add_argument("--work", required=True)
    parser.add_argument("--mesh", type=int, nargs=3, default=[24, 8, 1])
    options = parser.parse_args()
    print("| case | drive | CalculiX [N] | flexopt [N] | difference |\n|---|---|---|---|---|")
    for name, size in LENGTHS.items():
        solid = solid_factors(options.work, name, size, Mesh(*options.mesh))
        own = own_factors(os.path.abspath(options.flexopt), options.work, name, size) \
            if options.flexopt else {}
        for drive in solid:
            row = f"| {name} | {drive[6:]} | {solid[drive] * PAYLOAD:.6g} "
            if own:
                row += (f"| {own[drive] * PAYLOAD:.6g} "
                        f"| {100 * (own[drive] / solid[drive] - 1):+.2f} % ")
            print(row + "|")


if __name__ == "__main__":
    main()
