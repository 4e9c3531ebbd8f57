"""The drawings as files: well-formed, their words apart, their dimensions those of the design files.

test_svg_files.py FLEXOPT SOURCE WORK
"""
import json
import math
import pathlib
import subprocess
import sys
import xml.etree.ElementTree as tree

UNITS = {"mm": 1e-3, "m": 1, "deg": math.pi / 180, "rad": 1}
SVG = "{http://www.w3.org/2000/svg}"


def in_si(value):
    if isinstance(value, (int, float)):
        return value
    number, unit = value.split()
    return float(number) * UNITS[unit]


def points(text):
    return [tuple(map(float, pair.split(","))) for pair in text.split()]


def drawn_value(group):
    line = points(group.find(SVG + "polyline").get("points"))
    if group.get("data-vertex"):
        (x, y), = points(group.get("data-vertex"))
        a, b = (math.atan2(q - y, p - x) for p, q in (line[0], line[-1]))
        return abs(math.remainder(a - b, 2 * math.pi))
    return math.dist(line[0], line[-1]) / float(group.get("data-scale"))


def box(text):
    size, x, y = (float(text.get(key)) for key in ("font-size", "x", "y"))
    return x, y - 0.9 * size, x + float(text.get("textLength")), y + 0.3 * size


def check(svg, values):
    """Of a drawing and the design's parameters in SI; what has no value here is not compared."""
    root = tree.fromstring(svg)
    left, top, width, height = map(float, root.get("viewBox").split())
    boxes = [(box(text), text.text) for text in root.iter(SVG + "text")]
    for k, ((a, b, c, d), words) in enumerate(boxes):
        assert left <= a and top <= b and c <= left + width and d <= top + height, words
        for (e, f, g, h), others in boxes[:k]:
            assert not (a < g and e < c and b < h and f < d), (words, others)
    drawn = {}
    for group in root.iter(SVG + "g"):
        name, value = group.get("data-parameter"), float(group.get("data-value"))
        assert name not in drawn
        drawn[name] = value
        # three decimals of a pixel
        limit = 0.002 / (30 if group.get("data-vertex") else float(group.get("data-scale")))
        assert abs(drawn_value(group) - abs(value)) < limit, (name, drawn_value(group), value)
        if name in values:
            assert math.isclose(value, values[name], rel_tol=1e-9), (name, value, values[name])
    return drawn


def main():
    flexopt, source, work = sys.argv[1:]
    pathlib.Path(work).mkdir(parents=True, exist_ok=True)

    def run(*words):
        return subprocess.run([flexopt, *words], capture_output=True, text=True)

    for file in sorted(pathlib.Path(source, "designs/families").glob("*.json")):
        design = json.loads(file.read_text())
        values = {name: in_si(p.get("default", p.get("example")))
                  for name, p in design["parameters"].items() if p["unit"] in ("m", "rad")}
        drawn = check(run("designs", file.stem, "--svg").stdout, values)
        visible = {name for name, value in values.items() if value != 0}  # no radius of a sharp fold
        assert visible <= set(drawn), (file.stem, visible - set(drawn))

    for file in sorted(pathlib.Path(source, "designs/jobs").glob("*.json")):
        if "design" in json.loads(file.read_text()):
            drawn = run("show", str(file), "--svg")
            assert drawn.returncode == 0, drawn.stderr
            check(drawn.stdout, {})

    # a file has what stdout has; numbers of the job are drawn
    out = pathlib.Path(work, "guide.svg")
    job = f"{source}/designs/jobs/parallel_guide.json"
    told = run("show", job, "--set", '/design/parameters/length="62 mm"', "--svg", str(out))
    assert (told.returncode, told.stdout) == (0, f"{out}\n"), told
    assert check(out.read_text(), {"length": 0.062})["spacing"] == 0.1
    assert run("designs", "parallel_guide", "--svg", str(out)).stdout == f"{out}\n"
    assert out.read_text() == run("designs", "parallel_guide", "--svg").stdout

    for words in (["designs", "--svg"], ["designs", "no_family", "--svg"],
                  ["show", job, "--svg", "--open"],
                  ["designs", "parallel_guide", "--svg", f"{job}/no.svg"]):
        assert run(*words).returncode == 2, words
    assert "family" in run("designs", "--svg").stderr
    return 0


if __name__ == "__main__":
    sys.exit(main())
