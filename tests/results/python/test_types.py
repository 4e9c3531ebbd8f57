"""The types of the package are complete, and those of a program that uses it are checked."""

import subprocess
import sys

import pytest
from conftest import SOURCE

PROGRAM = '''
import flexopt
import numpy as np
from numpy.typing import NDArray

guide = flexopt.design("parallel_guide", length="100 mm")
r = flexopt.evaluate(guide, stroke={"to": "20 mm"}, gradients=["length"])
load: NDArray[np.float64] = r["drive_load"]
slope: NDArray[np.float64] = r.gradients["drive_load"]["length"]
best = flexopt.optimise("job.json", lambda done, total, text: None)
objective: float | None = best.objective
p = flexopt.Problem({"job": "optimise"}, pointwise=True)
value: float = p.f(p.x0)
try:
    flexopt.compare("job.json", out="folder")
except flexopt.NotConverged as error:
    stroke: float | None = error.stroke
'''


def mypy(*arguments):
    pytest.importorskip("mypy")
    return subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--cache-dir=/dev/null", *map(str, arguments)],
        capture_output=True, text=True, env={"MYPYPATH": str(SOURCE / "results/python"), "PATH": ""},
    )


def test_the_package_passes_strict_checks():
    checked = mypy(SOURCE / "results/python/flexopt")
    assert checked.returncode == 0, checked.stdout


def test_a_program_passes_and_a_wrong_one_does_not(tmp_path):
    program = tmp_path / "program.py"
    program.write_text(PROGRAM)
    checked = mypy(program)
    assert checked.returncode == 0, checked.stdout
    program.write_text(PROGRAM + "flexopt.evaluate(3)\nr.colour\np.f(x=1, y=2)\n")
    assert mypy(program).stdout.count("error:") == 3


def test_stubs_name_what_the_module_has():
    import ast

    from flexopt import _core

    stubs = ast.parse((SOURCE / "results/python/flexopt/_core.pyi").read_text())
    public = {name for name in dir(_core) if not name.startswith("_")}
    told = {
        getattr(node, "name", None) or node.target.id
        for node in stubs.body
        if isinstance(node, (ast.ClassDef, ast.FunctionDef, ast.AnnAssign))
    }
    assert told == public
    for node in stubs.body:
        if isinstance(node, ast.ClassDef):
            members = {name for name in dir(getattr(_core, node.name)) if not name.startswith("_")}
            told = {getattr(n, "name", None) or n.target.id for n in node.body}
            assert {name for name in told if not name.startswith("_")} == members, node.name
