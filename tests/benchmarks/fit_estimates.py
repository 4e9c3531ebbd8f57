#!/usr/bin/python3
"""The factors S, a, b of (S26) to (S28), from designs that bench_estimates wrote.

    bench_estimates 6 --csv estimates.csv
    fit_estimates.py estimates.csv

For each kind of numbers: the a and b with which most estimates are within five times the error, S being the least at
which 99.5 % of the errors are below their estimate. They stand in core/response/accuracy/error_estimate.cpp. Errors of
less than 1e-6 are rounding. Needs numpy.
"""
import csv
import itertools
import sys
from collections import defaultdict

import numpy as np

KINDS = {1: "load", 2: "stiffness", 3: "motion", 4: "frequency", 5: "stress"}
COVERED = 0.995
ORDER = 2
ROUNDING = 1e-4  # of the scale, what Newton's tolerance leaves of numbers that are zero


def rest(elements, own, finer):
    """Error over the difference to a mesh of so many elements more, (S26)."""
    return abs(own - finer) / (1 - (round(elements * 2 ** 0.5) / elements) ** -ORDER)


def read(path):
    """Columns of all numbers, with the mean squares along the path and at the point."""
    rows = list(csv.DictReader(open(path)))
    along, beside = defaultdict(list), defaultdict(list)
    table = []
    for r in rows:
        n, m, scale = int(r["n"]), int(r["m"]), float(r["scale"])
        own, longer, wider, truth = (float(r[k]) for k in ("own", "along", "across", "truth"))
        d = (rest(n, own, longer) + rest(m, own, wider)) / scale
        design = (r["design"], n, m)
        along[design, r["name"]].append(d * d)
        beside[design, r["point"], r["kind"]].append(d * d)
        table.append((int(r["kind"]), r["kind"] != "3" and abs(own) < scale, d, abs(own - truth) / scale, design, r["name"], r["point"], r["kind"]))
    columns = defaultdict(list)
    for kind, vanishes, d, error, design, name, point, text in table:
        rounding = ROUNDING if vanishes else 0
        path_mean = np.mean(along[design, name]) ** 0.5
        for key, value in zip(("d", "path", "point", "error", "rounding"),
                              (d, path_mean, np.mean(beside[design, point, text]) ** 0.5, error, rounding)):
            columns[kind, key].append(value)
    return {key: np.array(value) for key, value in columns.items()}


def judged(error, estimate):
    counts = error > 1e-6
    covered = np.mean(error <= np.maximum(estimate, 1e-6))
    sharp = np.mean(estimate[counts] <= 5 * error[counts])
    return covered, sharp


def fit(c, kind):
    d, path, point, error, rounding = (c[kind, k] for k in ("d", "path", "point", "error", "rounding"))
    best = None
    for a, b in itertools.product((0, 0.1, 0.2, 0.3, 0.6), (0, 0.1, 0.2, 0.3, 0.7)):
        smooth = np.sqrt(d ** 2 + (a * path) ** 2 + np.minimum(b * point, 3 * path) ** 2)
        for safety in np.arange(0.5, 4, 0.1):
            covered, sharp = judged(error, np.maximum(safety * smooth, rounding))
            if covered >= COVERED:
                if best is None or sharp > best[0]:
                    best = (sharp, covered, safety, a, b)
                break
    return best


def main():
    c = read(sys.argv[1])
    for kind, name in KINDS.items():
        if (kind, "d") not in c:
            continue
        best = fit(c, kind)
        if best is None:
            print(f"{name}: nothing covers {COVERED:.1%}")
            continue
        sharp, covered, safety, a, b = best
        print(f"{name:10} {len(c[kind, 'd'])} numbers: S {safety:.1f}  a {a}  b {b}"
              f"   below it {covered:.2%}, within 5 times {sharp:.1%}")


main()
