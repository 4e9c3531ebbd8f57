"""CalculiX runs decks and agrees with full accuracy within 1 %.

test_ccx_agrees.py FLEXOPT SOURCE WORK
"""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

PLATES = "/model/flexure=\"plate\""  # what beams leave out is not what is tested
MOTOR = '/loads=[{"name": "motor", "moment": ["0.3 N m", "-0.2 N m", "0.05 N m"]}]'
LEVER = '/loads=[{"name": "lever", "body": "stage", "moment": [0, 0, "2 N m"]}]'
RUBBER = '/design/tie="bushing"'
# of each deck: its job, changes, solids of a leaf, numbers that count
DECKS = {
    "parallel_guide": ("parallel_guide", [], "16 10 1", 6),
    "cross_hinge": ("cross_hinge", [], "14 8 1", 6),
    "double_parallelogram": ("double_parallelogram", [PLATES], "16 10 1", 6),
    "crooked_guide": ("crooked_guide", [], "16 10 1", 6),
    "wire_flexure": ("wire_flexure", [], "16 10 1", 6),
    "a hinge": ("hinged_leaf", [PLATES], "16 2 1", 2),
    "a drive on a body that moves": ("xy_stage", [], "16 8 1", 8),
    "moments": ("cross_hinge", [MOTOR], "14 8 1", 6),
    "a moment on another body": ("double_parallelogram", [PLATES, LEVER], "16 10 1", 6),
    "a bushing": ("tied", [RUBBER], "16 6 1", 6),
    "a ball and a bushing of a body that moves": ("tied", ['/design/tie="ball"'], "16 8 1", 6),
    "elastic bodies": ("elastic", [], "16 8 1", 6),
    "a slide": ("tied", ['/design/tie="slide"', "/stroke/to=0.0003"], "16 8 1", 1),
}
# those that do not wait for the night: clamped leaves, a body between, a joint, a spring
DAILY = ["parallel_guide", "double_parallelogram", "a hinge", "a bushing"]
TIED = {
    "flexopt": 1, "name": "tied", "job": "evaluate",
    "design": {"file": "", "material": {"youngs_modulus": "200 GPa", "poissons_ratio": 0.3,
                                        "density": "7800 kg/m^3"}},
    "end_effector": {"mass": "0.3 kg", "inertia": ["1e-4 kg m^2", "1e-4 kg m^2", "1e-4 kg m^2"]},
    "model": {"accuracy": "full", "flexure": "plate"},
    "stroke": {"to": "6 mm", "points": 3}, "frequencies": 4,
}


def run(flexopt, job, changes, solids, work, *more):
    """Exports and runs a deck; what compare_ccx.py says of it."""
    sets = [word for change in changes for word in ("--set", change)]
    subprocess.run([flexopt, "export", job, "--format", "ccx", "--out", work, "--solids",
                    *solids.split(), *sets, *more], check=True)
    deck = next(pathlib.Path(work).glob("*.inp"))
    subprocess.run(["ccx", deck.stem], cwd=work, check=True, stdout=subprocess.DEVNULL,
                   env=dict(os.environ, OMP_NUM_THREADS="1"))
    return deck, subprocess.run([sys.executable, f"{work}/compare_ccx.py", deck],
                                capture_output=True, text=True)


def main():
    flexopt, source, work = sys.argv[1:]
    if not shutil.which("ccx"):
        print("no ccx: install calculix-ccx")
        return 77
    shutil.rmtree(work, ignore_errors=True)
    os.makedirs(work)
    TIED["design"]["file"] = f"{source}/tests/results/export/tied_guide.json"
    pathlib.Path(work, "tied.json").write_text(json.dumps(TIED))
    failed = 0
    chosen = DECKS if "FLEXOPT_NIGHTLY" in os.environ else DAILY
    for name, (job, changes, solids, count) in ((name, DECKS[name]) for name in chosen):
        file = {"tied": f"{work}/tied.json",
                "elastic": f"{source}/tests/results/export/elastic_guide.json"}.get(
                    job, f"{source}/designs/jobs/{job}.json")
        folder = f"{work}/{name.replace(' ', '_')}"
        _, compared = run(flexopt, file, changes, solids, folder)
        print(name, compared.stdout, compared.stderr, sep="\n", flush=True)
        rows = re.findall(r"^(drive load|support stiffness)", compared.stdout, re.M)
        # linear steps of CalculiX leave out a part of the rigid bodies' tangent
        modes = [float(x) for x in re.findall(r"^frequency .* ([-+][0-9.]+) %", compared.stdout, re.M)]
        if compared.returncode != 0 or len(rows) != count or not modes or max(map(abs, modes)) > 2:
            print("FAILED:", name)
            failed += 1
    # at rest the drive has no load, which is no fault
    guide = f"{source}/designs/jobs/parallel_guide.json"
    failed += run(flexopt, guide, [], "12 8 1", f"{work}/rest", "--at", "0")[1].returncode != 0
    # the comparison itself must be able to fail
    deck = pathlib.Path(work, "parallel_guide", "parallel_guide.inp")
    text = deck.read_text()
    for factor in (1.02, 1.2):
        wrong = re.sub(r"(\*\*FLEXOPT drive_load .* value )(\S+)",
                       lambda m: m[1] + str(factor * float(m[2])), text)
        assert wrong != text
        deck.write_text(wrong)
        judged = subprocess.run([sys.executable, deck.parent / "compare_ccx.py", deck],
                                stdout=subprocess.PIPE, text=True)
        failed += judged.returncode != 1
        failed += ("apart in drive load uy" in judged.stdout) != (factor > 1.1)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
