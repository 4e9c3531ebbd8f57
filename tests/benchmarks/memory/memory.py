#!/usr/bin/env python3
"""Resident memory of runs that go on for long: whether it grows with the number of evaluations.

    memory.py PROGRAM [SECONDS_PER_KIND]

An optimisation of many starts, a global search and a served design that is moved again and again are looked at every quarter of a
second. The table gives the memory after a tenth of the run, at its end, and the growth in between for each evaluation, beside what
the log of an evaluation takes on the disk. Exit code 1 where more than that and a tenth of all stays behind.
"""

import http.client
import json
import os
import subprocess
import sys
import tempfile
import time
import urllib.parse

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "kills"))
from kills import HINGE, SEARCH  # noqa: E402

KINDS = {
    "optimise, many starts": {"job": "optimise", "optimise": SEARCH | {"starts": 400, "max_evaluations": 20000}},
    "global search": {"job": "optimise", "optimise": SEARCH | {"search": "global", "screened_designs": 32768, "starts": 2}},
}


def resident(pid):
    """[MB]"""
    with open(f"/proc/{pid}/status", encoding="ascii") as file:
        for line in file:
            if line.startswith("VmRSS"):
                return int(line.split()[1]) / 1024
    return 0.0


def watch(process, seconds, count, act=lambda: time.sleep(0.25)):
    """(evaluations, MB) until the time is over or the process has ended."""
    seen = []
    begin = time.monotonic()
    while process.poll() is None and time.monotonic() - begin < seconds:
        act()
        try:
            seen.append((count(), resident(process.pid)))
        except FileNotFoundError:
            break
    return seen


def lines_of(folder):
    def count():
        total = 0
        for name in ("evaluations.jsonl", "evaluations.screening.jsonl"):
            path = os.path.join(folder, name)
            if os.path.exists(path):
                with open(path, "rb") as file:
                    total += sum(chunk.count(b"\n") for chunk in iter(lambda f=file: f.read(1 << 20), b""))
        return total
    return count


def bytes_each(folder):
    size = sum(os.path.getsize(os.path.join(folder, name)) for name in os.listdir(folder) if name.endswith("jsonl"))
    return size / max(1, lines_of(folder)())


def run_kind(program, folder, name, parts, seconds):
    job, out = os.path.join(folder, "job.json"), os.path.join(folder, name.replace(" ", "_").replace(",", ""))
    with open(job, "w", encoding="utf-8") as file:
        json.dump(HINGE | parts, file)
    process = subprocess.Popen([program, "run", job, "--out", out, "--quiet", "--threads", "2"], stdout=subprocess.DEVNULL)
    seen = watch(process, seconds, lines_of(out))
    process.kill()
    process.wait()
    return seen, bytes_each(out)


def serve(program, folder, seconds):
    job = os.path.join(folder, "job.json")
    with open(job, "w", encoding="utf-8") as file:
        json.dump(HINGE | {"job": "evaluate"}, file)
    process = subprocess.Popen([program, "explore", job], stdout=subprocess.PIPE, text=True)
    address = urllib.parse.urlparse(process.stdout.readline().split()[-1])
    token = urllib.parse.parse_qs(address.query)["token"][0]
    answered = 0

    def move():
        nonlocal answered
        connection = http.client.HTTPConnection(address.hostname, address.port, timeout=60)
        body = json.dumps({"parameters": {"length": 0.05 + 0.02 * ((answered * 0.618034) % 1)}})
        connection.request("POST", "/evaluate", body, {"X-Flexopt-Token": token})
        answer = connection.getresponse()
        text = answer.read()
        if answer.status != 200:
            raise RuntimeError(f"{answer.status}: {text[:200]}")
        answered += 1
        connection.close()

    seen = watch(process, seconds, lambda: answered, move)
    process.kill()
    process.wait()
    return seen, 0.0


def main():
    program = os.path.abspath(sys.argv[1])
    seconds = float(sys.argv[2]) if len(sys.argv) > 2 else 600
    findings = 0
    print("| run | evaluations | memory after a tenth of them | at the end | growth per evaluation | its line in the log |")
    print("|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory(prefix="flexopt_memory_") as folder:
        kinds = {name: lambda n=name, p=parts: run_kind(program, folder, n, p, seconds) for name, parts in KINDS.items()}
        kinds["explore"] = lambda: serve(program, folder, seconds)
        for name, run in kinds.items():
            seen, line = run()
            last, end = seen[-1]
            first, begin = next(s for s in seen if s[0] >= 0.1 * last)
            growth = (end - begin) * 2**20 / max(1, last - first)
            # an optimisation keeps what its log has; ten times, as numbers and names in maps
            grows = end - begin > 0.1 * begin + 10 * line * (last - first) / 2**20
            findings += grows
            print(f"| {name} | {last} | {begin:.1f} MB | {end:.1f} MB{' FINDING' if grows else ''} | {growth:.0f} bytes | {line:.0f} bytes |", flush=True)
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
