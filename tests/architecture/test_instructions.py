"""All sets of instructions of the packages find the same numbers.

test_instructions.py PACKAGES SOURCE WORK
test_instructions.py PROGRAM OTHER SOURCE WORK

Unpacks the .deb files of PACKAGES, runs jobs of the gallery with the set for every processor and with
each other one that this processor can run, and compares all numbers of result.json with those of the
first. Two builds of one program round differently. Values agree within 1e-9, but for those of BEYOND; derivatives of frequencies, which are
small differences where a mode has next to no compliance, within 5e-7, optima within their stopping rules.
The second form compares two builds.
"""
import json
import pathlib
import re
import shutil
import subprocess
import sys

VALUES, DERIVATIVES, OPTIMA_WITHIN = 1e-9, 5e-7, 1e-5
# Measured: docs/robustness.md. Rounding of the stretch of full leaves, times the square of length over
# thickness; of the amplifier the screening frequency at rest.
BEYOND = {"folded_leaf": 3e-9, "bridge_amplifier": 5e-9}
ZERO = 1e-12  # by symmetry: what is left is rounding [SI]
JOBS = ["parallel_guide", "cross_hinge", "double_parallelogram", "crooked_guide", "wire_flexure",
        "cartwheel_hinge", "butterfly_hinge", "infinity_hinge", "curved_hinge", "curved_leaf",
        "tapered_leaf", "folded_leaf", "hinged_leaf", "xy_stage", "bridge_amplifier", "hexapod",
        "payload_on_guide", "roberts_guide", "spherical_joint", "tip_tilt_stage"]
OPTIMA = ["shaken_guide", "three_flexure_cross_hinge", "stiff_guide"]
# What is not one number of a mechanism: how far an iteration went; where, of several places with equal
# values, one was found; directions and modes, whose sign is free and which are any where two stiffnesses are equal;
# checks of reduced leaves, what a condition of an optimum is missed by: the little that two numbers differ.
NOT_COMPARED = re.compile(
    r"/(flexopt|newton_iterations|sub_steps|history|starts|evaluations|failed_evaluations|best_start"
    r"|expectations|screening|[a-z_]*_place|stress_peaks|direction|check"
    r"|state_space|mode|participation|margin|[a-z_]*difference|violation|kkt_residual|loop)(/|$)")
# Leaf modes of equal legs have equal frequencies: which mixture of them a point names, and so which one
# is followed along the path, is free.
EQUAL_MODES = {"hexapod": re.compile("/valid_to/")}
LOADER = "/lib64/ld-linux-x86-64.so.2"


def numbers(value, path=""):
    """[(pointer, number)] of all floats and integers."""
    if isinstance(value, dict):
        for key, own in value.items():
            yield from numbers(own, f"{path}/{key}")
    elif isinstance(value, list):
        for k, own in enumerate(value):
            yield from numbers(own, f"{path}/{k}")
    elif isinstance(value, (int, float)) and not isinstance(value, bool):
        if not NOT_COMPARED.search(path):
            yield path, float(value)


def difference(one, other, left_out=None):
    """Largest difference and where, of values and of derivatives: of each number over the largest of its
    kind, which is that of all places, directions and modes of the same key."""
    a, b = ({path: x for path, x in numbers(result) if not (left_out and left_out.search(path))}
            for result in (one, other))
    if a.keys() != b.keys():
        return ((float("inf"), sorted(a.keys() ^ b.keys())[0]),) * 2
    kind = lambda path: re.sub(r"/\d+", "/*", path)
    size = {}
    for path, x in a.items():
        size[kind(path)] = max(size.get(kind(path), ZERO), abs(x), abs(b[path]))
    derived = lambda path: "derivative" in path
    found = {False: (0.0, ""), True: (0.0, "")}
    for path, x in a.items():
        if size[kind(path)] > ZERO:
            own = (abs(x - b[path]) / size[kind(path)], path)
            found[derived(path)] = max(found[derived(path)], own)
    return found[False], found[True]


def programs_of(packages, work):
    """Ways to start the program of the packages, by the set of instructions."""
    root = work / "root"
    root.mkdir(parents=True)
    for pattern in ("flexopt_*.deb", "libflexopt0*.deb"):
        subprocess.run(["dpkg-deb", "-x", next(packages.glob(pattern)), root], check=True)
    library = next(root.rglob("libflexopt.so.*")).parent
    while library.name.startswith("x86-64") or library.name == "glibc-hwcaps":
        library = library.parent
    packed = sorted(folder.name for folder in (library / "glibc-hwcaps").iterdir())
    about = subprocess.run([LOADER, "--help"], capture_output=True, text=True).stdout
    sets = [name for name in packed if f"{name} (supported, searched)" in about]
    print("sets of the packages:", *packed, "- this processor runs:", *sets)
    ways = {name: [LOADER, "--glibc-hwcaps-mask", name, "--library-path", library]
            for name in ["first", *sets]}
    ways["chosen"] = [LOADER, "--library-path", library]
    program = root / "usr/bin/flexopt"
    for name, way in ways.items():
        listed = subprocess.run([*way, "--list", program], capture_output=True, text=True).stdout
        path = re.search(r"libflexopt\.so\S* => (\S+)", listed)[1]
        print(name, path)
        taken = sets[-1] if sets and name == "chosen" else name
        assert f"glibc-hwcaps/{taken}/" in path if taken in sets else "glibc-hwcaps" not in path, path
    del ways["chosen"]  # the last of them
    return {name: [*way, program] for name, way in ways.items()}


def main():
    *programs, source, work = (pathlib.Path(word).resolve() for word in sys.argv[1:])
    shutil.rmtree(work, ignore_errors=True)
    if len(programs) == 2:
        ways = {"first": [programs[0]], "other": [programs[1]]}
    else:
        ways = programs_of(programs[0], work)
    if len(ways) < 2:
        print("this processor runs one set of instructions")
        return 77
    failed = 0
    for job in JOBS + OPTIMA:
        results = {}
        for name, way in ways.items():
            out = work / f"{job}.{name}"
            ran = subprocess.run([*way, "run", source / f"designs/jobs/{job}.json", "--quiet",
                                  "--out", out], stdout=subprocess.DEVNULL)
            assert ran.returncode == 0, (job, name)
            results[name] = json.loads((out / "result.json").read_text())
        first, *others = results
        optimum = job in OPTIMA
        for name in others:
            limits = (BEYOND.get(job, VALUES), DERIVATIVES)
            found = difference(results[first], results[name], EQUAL_MODES.get(job))
            for (most, where), limit in zip(found, limits):
                print(f"{job:26} {name:10} {most:.1e} {where}", flush=True)
                failed += most > (OPTIMA_WITHIN if optimum else limit)
    # the comparison itself must be able to fail
    spoilt = json.loads(json.dumps(results[first]))
    spoilt["path"][0]["drive_stiffness"] *= 1 + 1e-4
    assert difference(spoilt, results[first])[0][0] > OPTIMA_WITHIN
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
