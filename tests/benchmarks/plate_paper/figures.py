#!/usr/bin/env python3
"""Figures 4, 6 and 7 of the plate superelement paper, each as SVG and CSV.

    tests/benchmarks/plate_paper/figures.py build/release/flexopt [FOLDER FOR THE RESULTS]

Runs the two gallery jobs *_superelements.json with other models and load paths. Prints the largest
deviation of every curve from the full plate, in per cent of the largest displacement of the figure.
"""
import json
import math
import pathlib
import subprocess
import sys
import tempfile

JOBS = pathlib.Path(__file__).parents[3] / "designs" / "jobs"
PATCHES = {"method": "linear_craig_bampton", "free_edge_torsion": False}
FULL = {"accuracy": "full", "free_edge_torsion": False}
BEAM = {"flexure": "beam"}


def run(program, job, model, points, load, folder):
    """Path points, or None where this version does not offer the model."""
    document = json.loads((JOBS / f"{job}.json").read_text())
    document.pop("expect")
    document["model"] = model
    document["frequencies"] = 0
    document["load_path"] = {"force": [0, load, 0], "points": points}
    (folder / "job.json").write_text(json.dumps(document))
    done = subprocess.run([program, "run", str(folder / "job.json"), "--out", str(folder / "out"),
                           "--quiet"], capture_output=True, text=True)
    if done.returncode == 2:
        print(f"left out, {json.dumps(model)}: {done.stderr.strip()}", file=sys.stderr)
        return None
    if done.returncode != 0:
        sys.exit(f"{job}: exit code {done.returncode}\n{done.stderr}")
    return json.loads((folder / "out" / "result.json").read_text())["path"]


def elastica(load):
    """(deflection, shortening)/L of a cantilever under P L²/EI: θ″ = −p cos θ, shot at θ(1) = tip."""
    def tip(curvature):
        n, y = 2000, [0.0, curvature, 0.0, 0.0]  # θ, θ′, x, y
        f = lambda s: (s[1], -load * math.cos(s[0]), math.cos(s[0]), math.sin(s[0]))
        for _ in range(n):
            h = 1 / n
            k1 = f(y)
            k2 = f([a + h / 2 * b for a, b in zip(y, k1)])
            k3 = f([a + h / 2 * b for a, b in zip(y, k2)])
            k4 = f([a + h * b for a, b in zip(y, k3)])
            y = [a + h / 6 * (p + 2 * q + 2 * r + s) for a, p, q, r, s in zip(y, k1, k2, k3, k4)]
        return y
    low, high = 0.0, load  # the root's curvature is less than that of the straight beam
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if tip(middle)[1] < 0 else (low, middle)
    end = tip(low)
    return end[3], 1 - end[2]


def write(folder, name, title, x_label, y_label, curves):
    """`curves`: (name, colour, dash, points)."""
    width, height, left, bottom = 640, 420, 70, 50
    x_max = max(x for c in curves for x, _ in c[3])
    y_max = 1.05 * max(y for c in curves for _, y in c[3])
    place = lambda x, y: (left + (width - left - 20) * x / x_max,
                          height - bottom - (height - bottom - 40) * y / y_max)
    svg = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
           'font-family="sans-serif" font-size="12">',
           f'<rect width="{width}" height="{height}" fill="white"/>',
           f'<text x="{left}" y="24" font-size="14">{title}</text>']
    for k in range(6):
        (x, base), (_, y) = place(x_max * k / 5, 0), place(0, y_max * k / 5)
        svg += [f'<path d="M{x:.1f} {base}V40M{left} {y:.1f}H{width - 20}" stroke="#ddd"/>',
                f'<text x="{x:.1f}" y="{base + 16}" text-anchor="middle">{x_max * k / 5:.3g}</text>',
                f'<text x="{left - 6}" y="{y + 4:.1f}" text-anchor="end">{y_max * k / 5:.2g}</text>']
    svg += [f'<text x="{(left + width) / 2}" y="{height - 12}" text-anchor="middle">{x_label}</text>',
            f'<text x="16" y="{height / 2}" text-anchor="middle" '
            f'transform="rotate(-90 16 {height / 2})">{y_label}</text>']
    for k, (label, colour, dash, points) in enumerate(curves):
        d = "M" + "L".join("{:.1f} {:.1f}".format(*place(*p)) for p in points)
        svg += [f'<path d="{d}" fill="none" stroke="{colour}" stroke-dasharray="{dash}"/>',
                f'<path d="M{left + 12} {52 + 15 * k}h24" stroke="{colour}" '
                f'stroke-dasharray="{dash}"/>',
                f'<text x="{left + 42}" y="{56 + 15 * k}">{label}</text>']
    (folder / f"{name}.svg").write_text("\n".join(svg + ["</svg>", ""]))
    rows = ["curve," + x_label + "," + y_label]
    rows += [f'"{c[0]}",{x:.10g},{y:.10g}' for c in curves for x, y in c[3]]
    (folder / f"{name}.csv").write_text("\n".join(rows) + "\n")
    print(f"{name}: {folder / name}.svg, .csv")


def deviation(name, curve, full):
    largest = max(abs(y) for _, y in full)
    worst = max(abs(a[1] - b[1]) for a, b in zip(curve, full)) / largest
    print(f"  {name}: {100 * worst:.2f} %")


def figure_4(program, out, folder):
    models = [("full plate", FULL, "#888", "none"),
              ("10 plate superelements", {**PATCHES, "superelements": [10, 1]}, "#000", "none"),
              ("10 beam superelements", {**PATCHES, **BEAM, "superelements": 10}, "#000", "6 4"),
              ("full beam", {**FULL, **BEAM}, "#888", "6 4")]
    curves = []
    for name, model, colour, dash in models:
        path = run(program, "cantilever_superelements", model, 41, "100 kN", folder)
        if path is None:
            continue
        for what, axis, sign in (("w/L", 1, 1), ("−u/L", 0, -1)):
            points = [(10 * p["stroke"], sign * p["displacement"][axis] / 10) for p in path]
            curves.append((f"{name}, {what}", colour, dash, points))
    loads = [x for x, _ in curves[0][3]]
    exact = [elastica(p) if p > 0 else (0.0, 0.0) for p in loads]
    for k, what in enumerate(("w/L", "−u/L")):
        curves.append((f"elastica, {what}", "#c00", "2 3", [(p, e[k]) for p, e in zip(loads, exact)]))
    write(out, "figure_4", "Cantilever under a tip load", "P L²/EI", "w/L, −u/L", curves)
    for k, curve in enumerate(curves[2:]):
        deviation(curve[0], curve[3], curves[k % 2][3])


def figure_6_7(program, out, folder, number, load):
    models = [("full plate", {**FULL, "mesh": [16, 16]}, "#888"),
              ("10 × 10 superelements", {**PATCHES, "superelements": [10, 10]}, "#000")]
    curves = []
    for name, model, colour in models:
        path = run(program, "clamped_plate_superelements", model, 26, f"{load} N", folder)
        at_load = [(load * p["stroke"], 1e3 * p["displacement"][1]) for p in path]
        opposite = [(load * p["stroke"], 1e3 * p["probes"]["opposite"]["displacement"][1])
                    for p in path]
        curves += [(f"{name}, A", colour, "none", at_load),
                   (f"{name}, opposite A", colour, "6 4", opposite)]
    write(out, f"figure_{number}", "Square plate clamped along two edges", "P [N]", "deflection [mm]",
          curves)
    for k in (0, 1):
        deviation(curves[2 + k][0], curves[2 + k][3], curves[k][3])


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    program = sys.argv[1]
    out = pathlib.Path(sys.argv[2] if len(sys.argv) > 2 else "plate_paper.out")
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        figure_4(program, out, folder)
        figure_6_7(program, out, folder, 6, 25)
        figure_6_7(program, out, folder, 7, 250)


main()
