"""What a call from Python costs beside its computation: ./flexopt python THIS, on an idle machine.

The time of a call less what the run itself took by its own clock (``seconds``), median of 300.
"""

import json
import pathlib
import statistics
import time

import flexopt

JOBS = pathlib.Path(__file__).resolve().parents[3] / "designs/jobs"


def microseconds(call, runs=300):
    """Median of what a call says, or of its time."""
    times = []
    for _ in range(runs):
        begin = time.perf_counter()
        computed = call()
        times.append(time.perf_counter() - begin - (computed or 0))
    return 1e6 * statistics.median(times)


def row(name, value):
    print(f"| {name} | {value:.1f} µs |")


job = json.loads((JOBS / "parallel_guide.json").read_text())
job.update(stroke={"at": [0]}, frequencies=1, expect=[], model={"accuracy": "full", "mesh": [4, 2]})
checked = flexopt.Job(job)
kept = []


def evaluate():
    kept[:] = [flexopt.evaluate(checked)]
    return kept[0].seconds


problem = flexopt.Problem(JOBS / "three_flexure_cross_hinge.json")
problem.df(problem.x0)
print("| call | beside its computation |\n|---|---|")
row(f"`evaluate(Job)`, {1e3 * evaluate():.1f} ms", microseconds(evaluate))
row("`result[quantity]`, again", microseconds(lambda: kept[0]["drive_stiffness"] is None))
row("`Problem.f(x)` of a design that is remembered", microseconds(lambda: problem.f(problem.x0) * 0))
row("`Job(dict)`", microseconds(lambda: flexopt.Job(job) is None))
