#!/usr/bin/env python3
"""Compares what CalculiX found with what flexopt says of the same mechanism.

    flexopt export JOB.json --format ccx --out FOLDER
    cd FOLDER && ccx NAME && python3 compare_ccx.py NAME.inp

The deck's lines **FLEXOPT say what to look for; NAME.dat has CalculiX's numbers. Exit code 1 where a
drive load or a support stiffness differs by more than --tolerance percent. Frequencies are shown
alone: linear steps of CalculiX leave out how the loads on a rigid body turn it, up to a percent. A
warning comes where any of these numbers differs by more than 10 percent, as on another branch.
"""
import argparse
import math
import pathlib
import sys

ROUNDING = 1e-9  # what is smaller is zero
OTHER_STATE = 10  # percent: more than solids and plates differ by


def tables(text):
    """Printed tables in their order: [(what, {node: (x, y, z)})]."""
    found = []
    for line in text.splitlines():
        words = line.split()
        if line.startswith((" displacements", " forces")):
            found.append((words[0], {}))
        elif len(words) == 4 and words[0].isdigit() and found:
            found[-1][1][int(words[0])] = tuple(float(w) for w in words[1:])
    return found


def spin_of_rate(v):
    """J in spin = J d(rotation vector)."""
    a = math.sqrt(sum(x * x for x in v))
    first = 0.5 if a < 1e-4 else (1 - math.cos(a)) / a**2
    second = 1 / 6 if a < 1e-4 else (a - math.sin(a)) / a**3
    hat = [[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]]
    square = [[sum(hat[i][k] * hat[k][j] for k in range(3)) for j in range(3)] for i in range(3)]
    return [[(i == j) + first * hat[i][j] + second * square[i][j] for j in range(3)]
            for i in range(3)]


def moment(v, load):
    """The moment that does the work of `load` on the rotation vector v: the solution of J^T m = load."""
    j = spin_of_rate(v)
    a = [[j[k][i] for k in range(3)] + [load[i]] for i in range(3)]
    for i in range(3):
        best = max(range(i, 3), key=lambda r: abs(a[r][i]))
        a[i], a[best] = a[best], a[i]
        for r in range(3):
            if r != i:
                a[r] = [x - a[r][i] / a[i][i] * y for x, y in zip(a[r], a[i])]
    return [a[i][3] / a[i][i] for i in range(3)]


def frequencies(text):
    """Natural frequencies [Hz] of the first table of eigenvalues."""
    found, inside = [], False
    for line in text.splitlines():
        words = line.split()
        if line.startswith("     E I G E N V A L U E   O U T P U T"):
            inside = True
        elif inside and len(words) == 5 and words[0] == str(len(found) + 1):
            found.append(float(words[3]))
        elif inside and found:
            break
    return found


def words_after(words, key, count=1):
    at = words.index(key) + 1
    return words[at:at + count]


def compare(deck, dat):
    """Rows (name, CalculiX, flexopt, unit)."""
    printed = tables(dat)
    moved = [t for what, t in printed if what == "displacements"]
    forces = [t for what, t in printed if what == "forces"]
    lines = [l.split()[1:] for l in deck.splitlines() if l.startswith("**FLEXOPT")]
    node, turned = next((int(w[2]), int(w[4])) for w in lines if w[0] == "end_effector")
    modes = frequencies(dat)
    rows = []
    for words in lines:
        kind, name = words[0], words[1]
        if "value" not in words:
            continue
        value = float(words_after(words, "value")[0])
        unit = " ".join(words[words.index("value") + 2:])
        axis = "xyz".find(name[-1])
        if kind in ("displacement", "rotation"):
            step = int(words_after(words, "step")[0])
            at = moved[step - 1][node if kind == "displacement" else turned]
            rows.append((f"{kind} {name}", at[axis], value, "m" if kind == "displacement" else "rad"))
        elif kind == "drive_load":
            step, own, dof = (int(words_after(words, k)[0]) for k in ("step", "node", "dof"))
            load = forces[step - 1][own]
            if own == turned:  # about the axis, not on the rotation vector
                load = moment(moved[step - 1][own], load)
                load = [m - float(x) for m, x in zip(load, words_after(words, "less", 3))]
            rows.append((f"drive load {name}", load[dof - 1], value, unit))
        elif kind == "frequency":
            rows.append((f"frequency {name}", modes[int(name) - 1], value, unit))
        elif kind == "support_stiffness":
            plus, minus = (int(w) for w in words_after(words, "steps", 2))
            load = float(words_after(words, "load")[0])
            own = node if name[0] == "u" else turned
            way = [p - m for p, m in zip(moved[plus - 1][own], moved[minus - 1][own])]
            if name[0] == "r":
                middle = [0.5 * (p + m) for p, m in
                          zip(moved[plus - 1][own], moved[minus - 1][own])]
                way = [sum(r * w for r, w in zip(row, way)) for row in spin_of_rate(middle)]
            rows.append((f"support stiffness {name}", 2 * load / way[axis], value, unit))
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("deck", type=pathlib.Path)
    parser.add_argument("--tolerance", type=float, default=1.0, help="percent [1]")
    options = parser.parse_args()
    rows = compare(options.deck.read_text(), options.deck.with_suffix(".dat").read_text())
    print(f"{'':24}{'CalculiX':>14}{'flexopt':>14}{'difference':>12}")
    agree, far = True, []
    for name, solid, ours, unit in rows:
        shown = name.startswith(("drive", "support", "frequency"))
        shown = shown and max(abs(ours), abs(solid)) > ROUNDING  # no drive load at rest
        difference = 100 * (ours / solid - 1) if shown and solid else math.inf
        if shown and not name.startswith("frequency"):
            agree = agree and abs(difference) <= options.tolerance
        if shown and abs(difference) > OTHER_STATE:
            far.append(name)
        text = f"{difference:+10.3f} %" if shown else ""
        print(f"{name:24}{solid:14.6g}{ours:14.6g}{text:>12}  {unit}")
    if far:
        print(f"warning: more than {OTHER_STATE} % apart in {', '.join(far)}: the two may stand in\n"
              "different states. Where several equilibria belong to a stroke, the way to it decides:\n"
              "try a tenth of the increments (*STATIC) in the step of the stroke.")
    return 0 if agree else 1


if __name__ == "__main__":
    sys.exit(main())
