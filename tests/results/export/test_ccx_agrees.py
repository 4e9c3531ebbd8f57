"""CalculiX runs the decks of three mechanisms and agrees with full accuracy within 1 %.

test_ccx_agrees.py FLEXOPT SOURCE WORK
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys

# A job of beams is compared as plates: what beams leave out is not what is tested.
JOBS = {"parallel_guide": [], "cross_hinge": [],
        "double_parallelogram": ["--set", '/model/flexure="plate"'],
        "crooked_guide": [], "wire_flexure": []}
MESH = {"cross_hinge": ["14", "8", "1"]}


def main():
    flexopt, source, work = sys.argv[1:]
    if not shutil.which("ccx"):
        print("no ccx: install calculix-ccx")
        return 77
    shutil.rmtree(work, ignore_errors=True)
    environment = dict(os.environ, OMP_NUM_THREADS="1")
    failed = 0
    for name, options in JOBS.items():
        subprocess.run([flexopt, "export", f"{source}/designs/jobs/{name}.json", "--format", "ccx",
                        "--out", work, "--solids", *MESH.get(name, ["16", "10", "1"]), *options],
                       check=True)
        subprocess.run(["ccx", name], cwd=work, env=environment, check=True,
                       stdout=subprocess.DEVNULL)
        compared = subprocess.run(
            [sys.executable, f"{work}/compare_ccx.py", f"{work}/{name}.inp"],
            capture_output=True, text=True)
        print(name, compared.stdout, compared.stderr, sep="\n", flush=True)
        failed += compared.returncode != 0
        rows = re.findall(r"^(drive load|support stiffness)", compared.stdout, re.M)
        failed += len(rows) != 6
        # linear steps of CalculiX leave out a part of the rigid bodies' tangent
        modes = [float(x) for x in re.findall(r"^frequency .* ([-+][0-9.]+) %", compared.stdout, re.M)]
        failed += not modes or max(map(abs, modes)) > 2
    # at rest the drive has no load, which is no fault
    at_rest = os.path.join(work, "rest")
    subprocess.run([flexopt, "export", f"{source}/designs/jobs/parallel_guide.json", "--format",
                    "ccx", "--out", at_rest, "--solids", "12", "8", "1", "--at", "0"], check=True)
    subprocess.run(["ccx", "parallel_guide"], cwd=at_rest, env=environment, check=True,
                   stdout=subprocess.DEVNULL)
    failed += subprocess.run([sys.executable, f"{at_rest}/compare_ccx.py",
                              f"{at_rest}/parallel_guide.inp"]).returncode != 0
    # the comparison itself must be able to fail
    deck = pathlib.Path(work, "parallel_guide.inp")
    text = deck.read_text()
    wrong = re.sub(r"(\*\*FLEXOPT drive_load .* value )(\S+)",
                   lambda m: m[1] + str(1.02 * float(m[2])), text)
    assert wrong != text
    deck.write_text(wrong)
    judged = subprocess.run([sys.executable, f"{work}/compare_ccx.py", str(deck)],
                            stdout=subprocess.DEVNULL)
    failed += judged.returncode != 1
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
