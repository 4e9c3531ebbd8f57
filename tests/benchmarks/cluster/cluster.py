"""What sharing a run costs: measured with the ranks that this machine has, simulated beyond.

    /usr/bin/python3 tests/benchmarks/cluster/cluster.py BUILD      # with bench_crew_messages in it

Writes the tables of docs/cluster.md and docs/cluster.png. Processor times, so that other work on the machine
is of little account.
"""

import heapq
import json
import os
import pathlib
import random
import re
import resource
import subprocess
import sys
import tempfile
import time

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[3]
BUILD = pathlib.Path(sys.argv[1]).resolve()
MPIRUN = ["mpirun", "--oversubscribe", "--bind-to", "none", "--mca", "btl", "self,vader"]
if os.geteuid() == 0:
    MPIRUN.append("--allow-run-as-root")


def timed(command):
    """Wall and processor seconds of a command with all its children."""
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.time()
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert done.returncode == 0, done.stderr
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return time.time() - begin, used, done.stdout


def measured(folder):
    """Rows of the table of ranks, and the seconds of each evaluation."""
    job = json.loads((ROOT / "designs/jobs/compare_parallel_guide.json").read_text())
    job["expect"] = []
    job["samples"]["count"] = 48
    file = folder / "guides.json"
    file.write_text(json.dumps(job))
    repeated = []
    for name in ("first", "second", "alone"):  # the least of each: other work takes its share of the clock
        wall, alone, _ = timed([BUILD / "flexopt", "run", file, "--quiet", "--threads", 1, "--out", folder / name])
        lines = (folder / name / "evaluations.seconds.jsonl").read_text().splitlines()[1:]
        repeated.append([json.loads(line)["total"] for line in lines])
    seconds = [min(times) for times in zip(*repeated)]
    rows = [f"| one process | {wall:.1f} | {alone:.1f} | – |"]
    for ranks in (1, 2, 4):
        wall, used, _ = timed([*MPIRUN, "-n", ranks, BUILD / "flexopt", "run", file, "--quiet", "--out",
                               folder / f"shared{ranks}"])
        same = (folder / "alone/evaluations.jsonl").read_bytes() == (
            folder / f"shared{ranks}/evaluations.jsonl").read_bytes()
        assert same
        rows.append(f"| mpirun -n {ranks} | {wall:.1f} | {used:.1f} | {100 * alone / used:.0f} % |")
    _, _, said = timed([*MPIRUN, "-n", 3, BUILD / "bench_crew_messages", folder / "alone/evaluations.jsonl"])
    return rows, seconds, json.loads(said)


def start_up(folder):
    """Processor milliseconds of a program that does next to nothing."""
    return min(timed([BUILD / "flexopt", "--version"])[1] for _ in range(20)) * 1e3


WORTH_A_MESSAGE = 0.2  # as optim/numerics/sharing.cpp


READERS = 3  # processors of rank 0 beside that of its messages


def efficiency(ranks, per_rank, seconds, message, chunks=True, seed=1):
    """Weak efficiency where units of work take these seconds, in random order, handed out as Sharing::run does.

    Rank 0 carries one message at a time and writes one line of the log at a time; its other threads, one for each
    rank, read the lines on READERS processors.
    """
    chance = random.Random(seed)
    units = [chance.choice(seconds) for _ in range(ranks * per_rank)]
    given, done, spent, free, end, readers = 0, 0, 0.0, 0.0, 0.0, [0.0] * READERS
    waiting = [(0.0, rank) for rank in range(ranks)]
    heapq.heapify(waiting)
    while given < len(units):
        at, rank = heapq.heappop(waiting)
        left = len(units) - given
        worth = int(WORTH_A_MESSAGE * done / spent) if spent else 1
        count = min(left, max(1, min(left // (4 * ranks), worth))) if chunks else 1
        work = sum(units[given:given + count])
        given += count
        free = max(free, at) + message["message"] + count * (message["unit"] - message["parse"])
        reader = min(range(READERS), key=readers.__getitem__)
        readers[reader] = max(readers[reader], free) + count * message["parse"]
        back = readers[reader] + message["round_trip"] + work
        done, spent = done + count, spent + work
        end = max(end, back)
        heapq.heappush(waiting, (back, rank))
    return sum(units) / ranks / end


def write(part, rows):
    page = ROOT / "docs/cluster.md"
    text = page.read_text()
    pattern = re.compile(rf"(<!-- bench cluster {part} -->\n).*?(<!-- end bench -->)", re.S)
    assert pattern.search(text), part
    page.write_text(pattern.sub(lambda m: m[1] + "\n" + "\n".join(rows) + "\n\n" + m[2], text))
    print("\n".join(rows))


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        rows, seconds, message = measured(folder)
        started = start_up(folder)
    mean = sum(seconds) / len(seconds)
    write("measured", [
        "| 48 guides of `compare_parallel_guide.json` | wall [s] | processors [s] | of one process |", "|---|---|---|---|",
        *rows, "",
        f"A message takes rank 0 {1e6 * message['message']:.0f} µs of its processor, each unit in it (a line of"
        f" {message['bytes']} bytes for the log)",
        f"{1e6 * message['unit']:.0f} µs, {1e6 * message['parse']:.0f} µs of that to read it, and the way to another rank and back {1e6 * message['round_trip']:.0f} µs; an"
        f" evaluation of this job {1e3 * mean:.0f} ms ({1e3 * min(seconds):.0f} to {1e3 * max(seconds):.0f}).",
        f"A program that is started alone takes {started:.0f} ms to start, with MPI in the build or without."])
    counts = [1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1000]
    cases = [("evaluations of this job, 256 a rank", seconds, 256, True),
             ("the same, one in each message", seconds, 256, False),
             ("a tenth of their time, 1280 a rank", [s / 10 for s in seconds], 1280, True)]
    table = ["| ranks | " + " | ".join(name for name, *_ in cases) + " |", "|---|" + "---|" * len(cases)]
    figure, axes = plt.subplots(figsize=(6, 3.4))
    curves = [[efficiency(ranks, per_rank, times, message, chunks) for ranks in counts]
              for _, times, per_rank, chunks in cases]
    for (name, *_), curve in zip(cases, curves):
        axes.semilogx(counts, [100 * value for value in curve], marker="o", ms=3, label=name)
    for i, ranks in enumerate(counts):
        if ranks in (1, 4, 16, 64, 256, 1000):
            table.append(f"| {ranks} | " + " | ".join(f"{100 * curve[i]:.1f} %" for curve in curves) + " |")
    axes.axhline(95, color="gray", lw=0.8, ls="--")
    axes.set(xlabel="ranks", ylabel="weak efficiency [%]", ylim=(80, 101))
    axes.legend(fontsize=8, loc="lower left")
    axes.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(ROOT / "docs/cluster.png", dpi=110, metadata={"Software": None})
    write("simulated", table)


if __name__ == "__main__":
    main()
