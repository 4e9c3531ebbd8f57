#!/usr/bin/env python3
"""Kills runs of every kind of job at random moments, spoils their logs, disks and folders, and counts how they end.

    kills.py PROGRAM [KILLS_PER_KIND] [SEED] [KIND…]

Of every kind a job runs through once; then it is killed (SIGKILL) after a random part of that time, again and again, and at
last left to end: result and log have to have the same bytes. A spoilt log may be refused in words (exit code 2) or resumed
to the same bytes; anything else is counted as a finding. Prints a table of counts; exit code 1 with findings.
"""

import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "support"))
from shared_jobs import CLOCKED, GUIDE, SLSQP, THICKEST, differences, jobs, write  # noqa: E402

KINDS = jobs() | {
    "evaluate": {**GUIDE, "name": "evaluate", "job": "evaluate", "frequencies": 8,
                 "stroke": {"from": 0, "to": "10 mm", "points": 41}},
    "verified": {**GUIDE, "name": "verified", "job": "optimise", "optimise": {
        **THICKEST, "algorithm": SLSQP, "verify": {"tolerance": 1e-3}, "starts": 1,
        "variables": [THICKEST["variables"][0] | {"step": "0.05 mm"}, THICKEST["variables"][1]]}},
}
for job in KINDS.values():
    if "optimise" in job:  # as many as the searches need to end well
        job["optimise"]["max_evaluations"] = 200


class Runner:
    def __init__(self, program, folder):
        self.program, self.folder = program, folder

    def start(self, job, out, **more):
        return subprocess.Popen([self.program, "run", job, "--out", out, "--quiet", "--threads", "2"],
                                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, **more)

    def run(self, job, out, **more):
        process = self.start(job, out, **more)
        try:
            _, words = process.communicate(timeout=300)
        except subprocess.TimeoutExpired:
            process.kill()
            return -99, "it hangs"
        return process.returncode, words


def fresh(folder, name):
    out = os.path.join(folder, name)
    shutil.rmtree(out, ignore_errors=True)
    return out


def logs_of(out):
    return [os.path.join(out, n) for n in sorted(os.listdir(out)) if n.startswith("evaluations") and n.endswith("jsonl") and n not in CLOCKED]


def main():
    program = os.environ["FLEXOPT_BINARY"] = os.path.abspath(sys.argv[1])
    kills_each = int(sys.argv[2]) if len(sys.argv) > 2 else 25
    chance = random.Random(int(sys.argv[3]) if len(sys.argv) > 3 else 1)
    findings = []
    rows = []
    with tempfile.TemporaryDirectory(prefix="flexopt_kills_") as folder:
        runner = Runner(program, folder)
        for kind, of_kind in KINDS.items():
            if sys.argv[4:] and kind not in sys.argv[4:]:
                continue
            job = write(of_kind, folder)
            through = fresh(folder, "through")
            begin = time.monotonic()
            code, words = runner.run(job, through)
            whole = time.monotonic() - begin
            if code != 0:
                findings.append(f"{kind}: exit code {code}: {words}")
                continue

            def compare(what, out):
                other = differences(through, out)
                if other:
                    findings.append(f"{kind}, {what}: other bytes in {', '.join(other)}")
                return not other

            # kills
            kills = same = ends = 0
            while kills < kills_each:
                out = fresh(folder, "killed")
                for _ in range(chance.randint(1, 6)):
                    process = runner.start(job, out)
                    time.sleep(whole * chance.random() * 0.9)
                    if process.poll() is None:
                        process.send_signal(signal.SIGKILL)
                        kills += 1
                    process.communicate()
                code, words = runner.run(job, out)
                ends += 1
                if code != 0:
                    findings.append(f"{kind}, killed: exit code {code}: {words}")
                else:
                    same += compare("killed", out)
            # logs that are torn or spoilt
            torn = refused = resumed = 0
            for log in [os.path.basename(path) for path in logs_of(through)]:
                for _ in range(max(4, kills_each // 3)):
                    out = fresh(folder, "spoilt")
                    os.mkdir(out)
                    with open(os.path.join(through, log), "rb") as file:
                        text = bytearray(file.read())
                    spoil = chance.choice(["cut", "bit", "zeros", "line"])
                    at = chance.randrange(1, len(text))
                    if spoil == "cut":
                        del text[at:]
                    elif spoil == "bit":
                        text[at] ^= 1 << chance.randrange(7)
                    elif spoil == "zeros":
                        text[at:at + 200] = bytes(len(text[at:at + 200]))
                    else:
                        end = text.find(b"\n", at)
                        del text[at:end]
                    with open(os.path.join(out, log), "wb") as file:
                        file.write(text)
                    torn += 1
                    code, words = runner.run(job, out)
                    if code == 2 and words.strip():
                        refused += 1
                    elif code == 0 and compare(f"log with {spoil} at {at}", out):
                        resumed += 1
                    elif code != 0:
                        findings.append(f"{kind}, log with {spoil} at {at}: exit code {code}: {words[:200]}")
            # a disk that is full
            full = 0
            for size in (200, 3000, 20000):
                out = fresh(folder, "full")

                def tight(size=size):
                    resource.setrlimit(resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))
                    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)

                code, words = runner.run(job, out, preexec_fn=tight)
                if code in (0, 2) and (code == 0 or words.strip()):
                    code, words = runner.run(job, out)
                    if code == 0 and compare(f"after a disk of {size} bytes", out):
                        full += 1
                        continue
                findings.append(f"{kind}, disk of {size} bytes: exit code {code}: {words[:200]}")
            # two runs in one folder: the same bytes at last, or a refusal
            out = fresh(folder, "two")
            both = [runner.start(job, out), runner.start(job, out)]
            ended = [(p.communicate(timeout=300)[1], p.returncode) for p in both]
            two = all(code == 0 or (code == 2 and words.strip()) for words, code in ended)
            code, words = runner.run(job, out)
            two = two and code == 0 and compare("two runs in one folder", out)
            if not two:
                findings.append(f"{kind}, two runs in one folder: {[(c, w[:80]) for w, c in ended]}, then {code}: {words[:80]}")
            rows.append((kind, kills, f"{same} of {ends}", torn, refused, resumed, f"{full} of 3", "same bytes" if two else "FINDING"))
    print("| job | kills | restarted to the same bytes | spoilt logs | refused in words | resumed to the same bytes "
          "| full disk | two runs in one folder |\n|---|---|---|---|---|---|---|---|")
    for row in rows:
        print("| " + " | ".join(str(cell) for cell in row) + " |")
    for finding in findings:
        print("finding:", finding, file=sys.stderr)
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
