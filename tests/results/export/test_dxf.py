"""ezdxf reads the drawings, and their outlines have the leaves' sizes.

test_dxf.py FLEXOPT SOURCE WORK
"""
import math
import pathlib
import shutil
import subprocess
import sys

try:
    import ezdxf
except ImportError:
    print("no ezdxf: install python3-ezdxf")
    sys.exit(77)


def outlines(path):
    """{layer: [points of closed polylines]}, of a file without faults."""
    drawing = ezdxf.readfile(path)
    auditor = drawing.audit()
    assert not auditor.errors and not auditor.fixes, (path, auditor.errors, auditor.fixes)
    assert drawing.header["$INSUNITS"] == 4  # mm
    found = {}
    for line in drawing.modelspace().query("POLYLINE"):
        assert line.dxf.layer in drawing.layers, line.dxf.layer
        points = [tuple(v.dxf.location)[:2] for v in line.vertices]
        found.setdefault(line.dxf.layer, []).append((line.is_closed, points))
    return found, drawing


def area(points):
    return abs(sum(x * q - p * y for (x, y), (p, q) in zip(points, points[1:] + points[:1]))) / 2


def length(points):
    return sum(math.dist(p, q) for p, q in zip(points, points[1:] + points[:1]))


def near(a, b, relative=1e-6):
    assert abs(a - b) <= relative * abs(b), (a, b)


def main():
    flexopt, source, work = sys.argv[1:]
    shutil.rmtree(work, ignore_errors=True)

    def export(name, *options):
        subprocess.run([flexopt, "export", f"{source}/designs/jobs/{name}.json", "--format", "dxf",
                        "--out", work, *options], check=True, stdout=subprocess.DEVNULL)
        return [pathlib.Path(work, f"{name}_{part}.dxf") for part in ("leaves", "contour")]

    def closed_ones(path):
        """{layer: [areas]} of outlines that are all closed and none twice, and the start points."""
        layers, drawing = outlines(path)
        assert all(closed for lines in layers.values() for closed, _ in lines)
        every = [frozenset(points) for lines in layers.values() for _, points in lines]
        assert len(set(every)) == len(every)
        starts = [tuple(p.dxf.location)[:2] for p in drawing.modelspace().query("POINT")]
        return {k: [area(p) for _, p in lines] for k, lines in layers.items()}, starts, layers

    # 100 x 30 x 0.5 mm, 100 mm apart, seen along z
    leaves, contour = export("parallel_guide")
    flat, drawing = outlines(leaves)
    assert set(flat) == {"L1_LEAF_PY"}, flat  # both leaves are cut alike
    for (closed, points), in flat.values():
        assert closed
        near(area(points), 3000)
        near(length(points), 260)
    words = [t.dxf.text for t in drawing.modelspace().query("TEXT")]
    assert any(w.startswith("2 x") and "leaf +y" in w and "0.5 mm" in w for w in words), words
    # one outline of ground, leaves and end-effector, around the hole between them
    areas, starts, layers = closed_ones(contour)
    assert set(areas) == {"CONTOUR", "HOLES"} and len(areas["CONTOUR"]) == 1, areas
    near(areas["HOLES"][0], 100 * 99.5)
    (_, points), = layers["CONTOUR"]
    depth = -min(x for x, _ in points)
    near(max(x for x, _ in points), 100 + depth)
    sides = max(y for _, y in points) - min(y for _, y in points)
    near(areas["CONTOUR"][0], sides * (100 + 2 * depth) - 100 * (sides - 100.5), 1e-5)
    assert starts[0][0] < -depth and len(starts) == 2
    assert 40 < starts[1][0] < 60 and abs(starts[1][1]) < 10, starts
    # the path of a wire
    _, contour = export("parallel_guide", "--kerf", "0.3 mm")
    near(closed_ones(contour)[0]["HOLES"][0], (100 - 0.3) * (99.5 - 0.3), 1e-5)
    wide = subprocess.run([flexopt, "export", f"{source}/designs/jobs/parallel_guide.json", "--out",
                           work, "--format", "dxf", "--kerf", "120 mm"], capture_output=True,
                          text=True)
    assert wide.returncode == 2 and "narrower than the cut" in wide.stderr, wide.stderr

    # bent: still one outline; the hole keeps its sides, and is shorter
    _, contour = export("parallel_guide", "--at", "20 mm")
    areas, _, layers = closed_ones(contour)
    assert len(areas["CONTOUR"]) == 1 and 9600 < areas["HOLES"][0] < 9800, areas

    # an arc of its length and its radius; between its ends no body is drawn
    leaves, contour = export("curved_leaf")
    arc = 60 * math.radians(30) / math.sin(math.radians(30))
    (_, points), = next(iter(outlines(leaves)[0].values()))
    near(area(points), arc * 4)
    areas, _, _ = closed_ones(contour)
    assert set(areas) == {"CONTOUR"} and areas["CONTOUR"][0] > arc * 0.4, areas

    # leaves in two plates: their sections alone
    _, contour = export("cross_hinge")
    areas, starts, _ = closed_ones(contour)
    assert len(areas) == 2 and not starts and "CONTOUR" not in areas

    # trapezes, folds
    leaves, _ = export("tapered_leaf")
    (_, points), = next(iter(outlines(leaves)[0].values()))
    assert len(points) == 4
    leaves, _ = export("folded_leaf", "--set", '/design/fold="elastic"')
    flat, _ = outlines(leaves)
    assert all(not closed and len(points) == 2 for closed, points in flat["FOLDS"])
    assert len(flat["FOLDS"]) == len(flat) - 1

    # leaves that are wide in several directions have no contour; wires no outline
    export("spherical_joint")
    assert pathlib.Path(work, "spherical_joint_leaves.dxf").exists()
    assert not pathlib.Path(work, "spherical_joint_contour.dxf").exists()
    refused = subprocess.run([flexopt, "export", f"{source}/designs/jobs/hexapod.json", "--format",
                              "dxf", "--out", work], capture_output=True, text=True)
    assert refused.returncode == 2 and "wires have no outline" in refused.stderr
    return 0


if __name__ == "__main__":
    sys.exit(main())
