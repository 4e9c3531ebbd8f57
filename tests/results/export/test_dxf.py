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

    # 100 x 30 x 0.5 mm, 100 mm apart, seen along z
    leaves, contour = export("parallel_guide")
    flat, drawing = outlines(leaves)
    assert set(flat) == {"L1_LEAF_PY", "L2_LEAF_MY"}, flat
    for (closed, points), in flat.values():
        assert closed
        near(area(points), 3000)
        near(length(points), 260)
    words = [t.dxf.text for t in drawing.modelspace().query("TEXT")]
    assert any("leaf +y" in w and "0.5 mm" in w for w in words), words
    cut, _ = outlines(contour)
    for (closed, points), in cut.values():
        assert closed
        near(area(points), 50)
        xs, ys = zip(*points)
        near(max(xs), 100)
        assert abs(min(xs)) < 1e-9
        near(abs(sum(ys)) / len(ys), 50)

    # bent: the same area, the tip 20 mm aside
    _, contour = export("parallel_guide", "--at", "20 mm")
    cut, _ = outlines(contour)
    (_, points), = cut["L1_LEAF_PY"]
    near(area(points), 50, 2e-3)
    near(max(y for _, y in points), 70.25, 1e-4)

    # an arc of its length and its radius
    leaves, contour = export("curved_leaf")
    arc = 60 * math.radians(30) / math.sin(math.radians(30))
    (_, points), = next(iter(outlines(leaves)[0].values()))
    near(area(points), arc * 4)
    (_, points), = next(iter(outlines(contour)[0].values()))
    near(area(points), arc * 0.4, 1e-4)

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
