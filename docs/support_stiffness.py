#!/usr/bin/env python3
"""Draws support_stiffness.png, the picture of README.md: a three-flexure cross hinge turned by 20°
either way, its support stiffness and frequencies over that turn, computed by the job of the gallery.

    docs/support_stiffness.py build/release/flexopt

Needs Python and, to turn the drawing (SVG) into a picture, Chromium.
"""
import csv
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
JOB = HERE.parent / "designs/jobs/three_flexure_cross_hinge.json"
WIDTH, HEIGHT = 1040, 300
COLOURS = ["#1f5fa8", "#c7522a", "#2f8f5b"]


def path_of(program, folder):
    """Columns of path.csv by name, units left out."""
    subprocess.run([program, "run", str(JOB), "--quiet", "--out", str(folder),
                    "--set", '/job="evaluate"', "--set", "/expect=[]",
                    "--set", '/stroke/from="-20 deg"', "--set", "/stroke/points=41"],
                   check=True, stdout=subprocess.DEVNULL)
    with open(folder / "path.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    return {key.split(" [")[0]: [row[key] for row in rows] for key in rows[0]}


def text(x, y, words, size=12, anchor="middle", colour="#222"):
    return (f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size}" text-anchor="{anchor}" '
            f'fill="{colour}">{words}</text>')


def panel(left, title, angle, curves, logarithmic):
    """One diagram: axes, grid and curves {name: values}."""
    x0, y0, w, h = left + 52, 34, 270, 210
    top = max(max(v) for v in curves.values())
    if logarithmic:
        low = math.floor(math.log10(min(min(v) for v in curves.values())))
        high = math.ceil(math.log10(top))
        ticks = [(k - low) / (high - low) for k in range(low, high + 1)]
        labels = [f"10{''.join('⁰¹²³⁴⁵⁶⁷⁸⁹'[int(d)] for d in str(k))}" for k in range(low, high + 1)]
        height = lambda v: (math.log10(v) - low) / (high - low)
    else:
        step = 100 * max(1, round(top / 400))
        count = math.ceil(top / step)
        ticks = [k / count for k in range(count + 1)]
        labels = [str(step * k) for k in range(count + 1)]
        height = lambda v: v / (count * step)
    across = lambda a: x0 + w * (a - angle[0]) / (angle[-1] - angle[0])
    out = [text(x0 + w / 2, 20, title, 13)]
    for place, label in zip(ticks, labels):
        y = y0 + h * (1 - place)
        out.append(f'<path d="M{x0} {y:.1f}h{w}" stroke="#ddd"/>')
        out.append(text(x0 - 6, y + 4, label, 11, "end"))
    for a in (-20, -10, 0, 10, 20):
        out.append(text(across(a), y0 + h + 16, f"{a}°".replace("-", "−"), 11))
    out.append(text(x0 + w / 2, y0 + h + 36, "turn of the hinge", 12))
    for k, (name, values) in enumerate(curves.items()):
        points = " ".join(f"{across(a):.1f},{y0 + h * (1 - height(v)):.1f}"
                          for a, v in zip(angle, values))
        out.append(f'<polyline points="{points}" fill="none" stroke="{COLOURS[k]}" '
                   'stroke-width="2"/>')
        out.append(text(x0 + 8, y0 + 16 + 16 * k, name, 12, "start", COLOURS[k]))
    return out


def main():
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        path = path_of(sys.argv[1], folder)
        number = lambda key: [float(v) for v in path[key]]
        angle = [math.degrees(s) for s in number("stroke")]
        out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" '
               'font-family="sans-serif">', '<rect width="100%" height="100%" fill="white"/>']
        out += panel(0, "support stiffness [N/m]", angle,
                     {d: number(f"support_stiffness.{d}") for d in ("ux", "uy", "uz")}, True)
        out += panel(345, "support stiffness [N m/rad]", angle,
                     {d: number(f"support_stiffness.{d}") for d in ("rx", "ry")}, True)
        out += panel(690, "natural frequencies, drive held [Hz]", angle,
                     {f"mode {k + 1}": number(f"frequencies.drive_locked.{k}") for k in range(3)},
                     False)
        drawing = folder / "drawing.svg"
        drawing.write_text("\n".join(out + ["</svg>"]))
        browser = shutil.which("chromium") or sys.exit("no chromium to make the picture with")
        subprocess.run([browser, "--headless", "--no-sandbox", "--disable-gpu",
                        "--hide-scrollbars", f"--window-size={WIDTH},{HEIGHT}",
                        f"--screenshot={HERE / 'support_stiffness.png'}", drawing.as_uri()],
                       check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


if __name__ == "__main__":
    main()
