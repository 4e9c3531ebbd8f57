"""What a call from Python costs beside its computation: ./flexopt python THIS, on an idle machine.

The time of a call, and of the end of the result before it, less what the run itself took by its own
clock (``seconds``): median of 300 calls, in five rounds. Where ./flexopt bench library_calls has built
its program, what the same call costs from C++, round by round, and what Python adds.
"""

import json
import pathlib
import statistics
import subprocess
import time

import flexopt

ROOT = pathlib.Path(__file__).resolve().parents[3]
JOBS = ROOT / "designs/jobs"
OF_LIBRARY = ROOT / "build/release/bench_library_calls"


def microseconds(call, runs=300):
    """Median of the time of a call."""
    times = []
    for _ in range(runs):
        begin = time.perf_counter()
        call()
        times.append(time.perf_counter() - begin)
    return 1e6 * statistics.median(times)


def row(name, values):
    print(f"| {name} | {', '.join(f'{value:.1f}' for value in values)} µs |")


job = json.loads((JOBS / "parallel_guide.json").read_text())
job.update(stroke={"at": [0]}, frequencies=1, expect=[], model={"accuracy": "full", "mesh": [4, 2]})
checked = flexopt.Job(job)
kept = flexopt.evaluate(checked)


def evaluations():
    """Medians: beside the computation, the end of the result before it with it, and that itself [s]."""
    kept, beside, itself = flexopt.evaluate(checked), [], []
    for _ in range(300):
        begin = time.perf_counter()
        kept = flexopt.evaluate(checked)
        whole = time.perf_counter() - begin
        itself.append(kept.seconds)
        beside.append(whole - kept.seconds)
    return 1e6 * statistics.median(beside), statistics.median(itself)


def from_cpp():
    said = subprocess.run([OF_LIBRARY], text=True, capture_output=True, check=True)
    return float(said.stdout.split()[0])


problem = flexopt.Problem(JOBS / "three_flexure_cross_hinge.json")
problem.df(problem.x0)
rounds = [(*evaluations(), from_cpp() if OF_LIBRARY.exists() else 0.0) for _ in range(5)]
print("| call | beside its computation |\n|---|---|")
computed = ", ".join(f"{1e3 * seconds:.1f}" for _, seconds, _ in rounds)
row(f"`evaluate(Job)`, {computed} ms", [python for python, _, _ in rounds])
if OF_LIBRARY.exists():
    row("the same from C++", [cpp for _, _, cpp in rounds])
    row("Python adds", [python - cpp for python, _, cpp in rounds])
row("`result[quantity]`, again", [microseconds(lambda: kept["drive_stiffness"])])
row("`Problem.f(x)` of a design that is remembered", [microseconds(lambda: problem.f(problem.x0))])
row("`Job(dict)`", [microseconds(lambda: flexopt.Job(job))])
