#!/usr/bin/env python3
"""Figures 1 to 6 of the modal-derivative paper, each as SVG and CSV.

    tests/benchmarks/modal_derivative_paper/figures.py build/release/flexopt
        build/release/bench_modal_shapes [FOLDER FOR THE RESULTS]

Beam leaves with 10 elements, as in the paper. 1 to 3: cantilever, from bench_modal_shapes. 4 and 5:
parallel leaf springs and cross flexure under a load; 6: the same springs under an increased one, and
their load and longitudinal support stiffness over the stroke, with the default reduction. Prints the
largest deviation of every model from the full one.
"""
import csv
import io
import json
import math
import pathlib
import subprocess
import sys
import tempfile

LENGTH, WIDTH, THICKNESS, SPACING, GAP = 0.1, 0.03, 5e-4, 0.06, 1e-3
MATERIAL = {"name": "steel", "youngs_modulus": "210 GPa", "poissons_ratio": 0.3,
            "density": "7800 kg/m^3"}
MODELS = [("full", {"accuracy": "full"}, "#888", "none"),
          ("modal derivatives, bending",
           {"method": "modal_derivatives", "modal_derivatives": "bending"}, "#c60", "6 4"),
          ("modal derivatives, all", {"method": "modal_derivatives"}, "#06c", "6 4"),
          ("with third-order fields",
           {"method": "modal_derivatives", "modal_derivatives": "third_order"}, "#080", "2 3"),
          ("default (tube)", {}, "#000", "2 3")]


def bounds(values, margin=0.05):
    low, high = min(values), max(values)
    extra = margin * (high - low or 1)
    return low - extra, high + extra


def write(folder, name, title, x_label, y_label, curves, equal=False, log=False):
    """`curves`: (name, colour, dash, points), of equal names only the first is in the legend."""
    width, height, left, bottom, top = 640, 420, 76, 50, 40
    scale = (lambda y: math.log10(y)) if log else (lambda y: y)
    x0, x1 = bounds([x for c in curves for x, _ in c[3]])
    y0, y1 = bounds([scale(y) for c in curves for _, y in c[3]])
    w, h = width - left - 20, height - bottom - top
    if equal:  # one unit for both axes
        unit = max((x1 - x0) / w, (y1 - y0) / h)
        xm, ym = 0.5 * (x0 + x1), 0.5 * (y0 + y1)
        x0, x1, y0, y1 = (xm - unit * w / 2, xm + unit * w / 2, ym - unit * h / 2,
                          ym + unit * h / 2)
    place = lambda x, y: (left + w * (x - x0) / (x1 - x0), top + h * (y1 - scale(y)) / (y1 - y0))
    svg = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
           'font-family="sans-serif" font-size="12">',
           f'<rect width="{width}" height="{height}" fill="white"/>',
           f'<text x="{left}" y="24" font-size="14">{title}</text>']
    for k in range(6):
        x, y = left + w * k / 5, top + h * (5 - k) / 5
        y_value = y0 + (y1 - y0) * k / 5
        svg += [f'<path d="M{x:.1f} {top + h}V{top}M{left} {y:.1f}H{left + w}" stroke="#ddd"/>',
                f'<text x="{x:.1f}" y="{top + h + 16}" text-anchor="middle">'
                f'{x0 + (x1 - x0) * k / 5:.3g}</text>',
                f'<text x="{left - 6}" y="{y + 4:.1f}" text-anchor="end">'
                f'{10 ** y_value if log else y_value:.2g}</text>']
    svg += [f'<text x="{left + w / 2}" y="{height - 12}" text-anchor="middle">{x_label}</text>',
            f'<text x="16" y="{height / 2}" text-anchor="middle" '
            f'transform="rotate(-90 16 {height / 2})">{y_label}</text>']
    shown = {}
    for label, colour, dash, points in curves:
        d = "M" + "L".join("{:.1f} {:.1f}".format(*place(*p)) for p in points)
        svg.append(f'<path d="{d}" fill="none" stroke="{colour}" stroke-dasharray="{dash}"/>')
        if label in shown:
            continue
        y = top + 14 + 15 * len(shown)
        shown[label] = True
        svg += [f'<path d="M{left + 12} {y - 4}h24" stroke="{colour}" stroke-dasharray="{dash}"/>',
                f'<text x="{left + 42}" y="{y}">{label}</text>']
    (folder / f"{name}.svg").write_text("\n".join(svg + ["</svg>", ""]))
    rows = [f'curve,"{x_label}","{y_label}"']
    rows += [f'"{c[0]}",{x:.10g},{y:.10g}' for c in curves for x, y in c[3]]
    (folder / f"{name}.csv").write_text("\n".join(rows) + "\n")
    print(f"{name}: {folder / name}.svg, .csv")


# ------------------------------------------------------------------- figures 1 to 3: a cantilever

COLOURS = ["#000", "#06c", "#c60", "#080", "#909"]


def cantilever_figures(program, out):
    text = subprocess.run([program], capture_output=True, text=True, check=True).stdout
    table, remark = text.split("\n\n", 1)
    data = {}
    for row in csv.DictReader(io.StringIO(table)):
        data.setdefault(row["figure"], {}).setdefault(row["curve"], []).append(
            (float(row["x"]), float(row["u"]), float(row["v"])))
    titles = {"1": "Vibration modes (across) and modal derivatives (along) of a cantilever",
              "2": "Craig–Bampton modes of the right node (across), derivatives (along)"}
    for figure in ("1", "2"):
        curves = []
        for k, (name, points) in enumerate(data[figure].items()):
            part = 1 if name.startswith("theta") else 2
            largest = max(abs(p[part]) for p in points)
            curves.append((f"{name}{'' if part == 2 else ', u'}", COLOURS[k % 5],
                           "none" if part == 2 else "6 4",
                           [(p[0], p[part] / largest) for p in points]))
        write(out, f"figure_{figure}", titles[figure], "x/L", "v or u, largest 1", curves)
    curves = []
    for (name, points), colour, dash in zip(data["3"].items(), ("#888", "#06c", "#c60"),
                                            ("none", "6 4", "2 3")):
        curves.append((name, colour, dash, [(x + u, v) for x, u, v in points]))
    write(out, "figure_3", "Cantilever under a tip load, P L²/EI = 2", "x/L", "y/L", curves,
          equal=True)
    loads = data["3 load"]
    write(out, "figure_3_load", "Tip deflection of the cantilever", "P L²/EI", "v/L",
          [(name, colour, dash, [(p[0], p[2]) for p in loads[name]])
           for name, colour, dash in zip(loads, ("#888", "#06c", "#c60"), ("none", "6 4", "2 3"))])
    full = {p[0]: p[2] for p in loads["full"]}
    for name in list(loads)[1:]:
        at = {p[0]: p[2] for p in loads[name]}
        print("  {}: deflection {}".format(name, ", ".join(
            f"{100 * (at[p] / full[p] - 1):+.2f} % at P L²/EI = {p:g}" for p in (1, 2, 4) if p in at)))
    print("\nWhat leaving out the inertia changes of the modal derivatives:\n\n" + remark)


# ----------------------------------------------------------------------- figures 4 to 6: mechanisms

def run(program, document, folder):
    """Path points, or None where the model finds no equilibrium."""
    (folder / "job.json").write_text(json.dumps(document))
    done = subprocess.run([program, "run", str(folder / "job.json"), "--out", str(folder / "out"),
                           "--quiet"], capture_output=True, text=True)
    if done.returncode == 2:
        sys.exit(done.stderr)
    path = json.loads((folder / "out" / "result.json").read_text())["path"]
    return path if done.returncode == 0 else None


def job(family, model, **keys):
    parameters = {"length": LENGTH, "width": WIDTH, "thickness": THICKNESS}
    if family == "parallel_guide":
        parameters["spacing"] = SPACING
    else:
        parameters["gap"] = GAP
    return {"flexopt": 1, "job": "evaluate",
            "design": {"family": family, "parameters": parameters, "material": MATERIAL},
            "model": {"flexure": "beam", "mesh": [10, 4], **model}, "frequencies": 0, **keys}


def probes(lines):
    """21 places along every line (from, to)."""
    result = []
    for k, (a, b) in enumerate(lines):
        for i in range(21):
            result.append({"name": f"{k}_{i}",
                           "at": [p + (q - p) * i / 20 for p, q in zip(a, b)]})
    return result


def shape(path_point, places):
    lines = {}
    for place in places:
        u = path_point["probes"][place["name"]]["displacement"]
        line = int(place["name"].split("_")[0])
        lines.setdefault(line, []).append((place["at"][0] + u[0], place["at"][1] + u[1]))
    return list(lines.values())


def deformed(program, out, folder, name, title, family, lines, load, models):
    places = probes(lines)
    curves, full = [], None
    for label, model, colour, dash in models:
        path = run(program, job(family, model, probes=places, load_path={**load, "points": 11}),
                   folder)
        if path is None:
            print(f"  {label}: no equilibrium")
            continue
        end = shape(path[-1], places)
        curves += [(label, colour, dash, [(1e3 * x, 1e3 * y) for x, y in line]) for line in end]
        if full is None:
            full = end
            rest = [[tuple(p["at"][:2]) for p in places if p["name"].startswith(f"{k}_")]
                    for k in range(len(lines))]
            moved = max(abs(complex(*a) - complex(*b)) for s, t in zip(full, rest)
                        for a, b in zip(s, t))
        else:
            worst = max(abs(complex(*a) - complex(*b)) for s, t in zip(end, full)
                        for a, b in zip(s, t))
            print(f"  {label}: {100 * worst / moved:.3f} % of the largest displacement")
    write(out, name, title, "x [mm]", "y [mm]", curves, equal=True)


def over_stroke(program, out, folder):
    curves_load, curves_stiffness, full = [], [], None
    for label, model, colour, dash in MODELS:
        document = job("parallel_guide", model,
                       stroke={"from": 0, "to": 0.3 * LENGTH, "points": 31})
        path = run(program, document, folder)
        if path is None:
            print(f"  {label}: no equilibrium")
            continue
        load = [(1e3 * p["stroke"], p["drive_load"]) for p in path]
        stiffness = [(1e3 * p["stroke"], p["support_stiffness"]["ux"]) for p in path]
        curves_load.append((label, colour, dash, load))
        curves_stiffness.append((label, colour, dash, stiffness))
        if full is None:
            full = (load, stiffness)
            continue
        worst = [max(abs(a[1] / b[1] - 1) for a, b in list(zip(own, exact))[1:])
                 for own, exact in zip((load, stiffness), full)]
        print(f"  {label}: drive load {100 * worst[0]:.3g} %, stiffness in x {100 * worst[1]:.3g} %")
    write(out, "figure_6_load", "Parallel leaf springs to 0.3 L", "stroke [mm]", "load [N]",
          curves_load)
    write(out, "figure_6_stiffness", "Parallel leaf springs to 0.3 L", "stroke [mm]",
          "longitudinal stiffness [N/m]", curves_stiffness, log=True)


def main():
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    program, shapes = sys.argv[1:3]
    out = pathlib.Path(sys.argv[3] if len(sys.argv) > 3 else "modal_derivative_paper.out")
    out.mkdir(parents=True, exist_ok=True)
    cantilever_figures(shapes, out)
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        springs = [((0, s * SPACING / 2, 0), (LENGTH, s * SPACING / 2, 0)) for s in (1, -1)]
        deformed(program, out, folder, "figure_4", "Parallel leaf springs, 25 N", "parallel_guide",
                 springs, {"force": [0, 25, 0]}, MODELS)
        a, z = LENGTH / 2 ** 1.5, (WIDTH + GAP) / 2
        crossing = [((-a, -s * a, s * z), (a, s * a, s * z)) for s in (1, -1)]
        deformed(program, out, folder, "figure_5", "Cross flexure, 0.7 N m", "cross_hinge",
                 crossing, {"moment": [0, 0, 0.7]}, MODELS)
        deformed(program, out, folder, "figure_6", "Parallel leaf springs, 60 N", "parallel_guide",
                 springs, {"force": [0, 60, 0]}, MODELS)
        over_stroke(program, out, folder)


main()
