"""Runs that mpirun shares leave the bytes of one process, also after a rank was killed.

Exit code 77, "skipped", without mpirun or where the program was built without MPI.
"""

import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
import shared_jobs  # noqa: E402

PROGRAM = pathlib.Path(os.environ["FLEXOPT_BINARY"])
MPIRUN = ["mpirun", "--oversubscribe", "--bind-to", "none", "--mca", "btl", "self,vader,tcp",
          "--mca", "btl_tcp_if_include", "lo", "--mca", "oob_tcp_if_include", "lo"]
if os.geteuid() == 0:
    MPIRUN.append("--allow-run-as-root")


def mpirun(ranks, file, out):
    return shared_jobs.run(*MPIRUN, "-n", ranks, PROGRAM, "run", file, "--quiet", "--out", out)


def alone(folder, job):
    file, out = shared_jobs.write(job, folder), folder / f"{job['name']}.alone"
    done = shared_jobs.run(PROGRAM, "run", file, "--quiet", "--threads", 1, "--out", out)
    assert done.returncode <= 1, done.stderr
    return file, out, done


def test_every_kind_of_job_has_the_bytes_of_one_process(folder):
    for name, job in shared_jobs.jobs().items():
        if name == "derivative_free":  # as "global"
            continue
        file, out, done = alone(folder, job)
        for ranks in (2, 4) if name == "compare" else (2,):
            shared = folder / f"{name}.{ranks}"
            found = mpirun(ranks, file, shared)
            assert found.returncode == done.returncode, found.stderr
            assert found.stdout.count("results: ") == 1, found.stdout
            differ = shared_jobs.differences(out, shared)
            assert not differ, f"{name} with {ranks} ranks: {differ}"


def ranks_of(launcher):
    """Process numbers by rank."""
    found = {}
    for entry in pathlib.Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            parent = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
            environment = (entry / "environ").read_bytes().split(b"\0")
        except (OSError, ValueError):
            continue
        for word in environment:
            if parent == launcher and word.startswith(b"OMPI_COMM_WORLD_RANK="):
                found[int(word.partition(b"=")[2])] = int(entry.name)
    return found


def lines(file):
    return file.read_bytes().count(b"\n") if file.exists() else 0


def test_a_rank_that_is_killed_costs_what_it_was_doing(folder):
    job = {**shared_jobs.jobs()["compare"], "name": "killed"}
    job["samples"] = {**job["samples"], "count": 24}
    file, out, _ = alone(folder, job)
    for victim in (1, 0):
        shared = folder / f"without.{victim}"
        log = shared / "evaluations.jsonl"
        with open(folder / "killed.err", "wb") as err:
            run = subprocess.Popen([*MPIRUN, "-n", "3", str(PROGRAM), "run", str(file), "--quiet", "--out",
                                    str(shared)], stdout=err, stderr=err)
            while lines(log) < 6 and run.poll() is None:
                time.sleep(0.005)
            assert run.poll() is None, (folder / "killed.err").read_text()
            os.kill(ranks_of(run.pid)[victim], signal.SIGKILL)
            assert run.wait(60) != 0
        kept = lines(log)
        assert 6 <= kept < lines(out / "evaluations.jsonl") and not (shared / "result.json").exists()
        again = mpirun(2, file, shared)
        assert again.returncode == 0, again.stderr
        differ = shared_jobs.differences(out, shared)
        assert not differ, f"rank {victim} killed after {kept} lines: {differ}"


def test_what_is_wrong_is_said_once(folder):
    job = shared_jobs.jobs()["compare"]
    job["name"], job["stroke"] = "wrong", {"to": "5 N", "points": 3}
    file = shared_jobs.write(job, folder)
    found = mpirun(3, file, folder / "wrong")
    assert found.returncode == 2, found.stderr
    assert found.stderr.count("/stroke/to") == 1, found.stderr


def test_processes_that_cannot_meet_are_refused(folder):
    """Each would write the whole run into the same folder."""
    file = shared_jobs.write({**shared_jobs.jobs()["around"], "name": "refused"}, folder)
    (folder / "bare").mkdir()
    program = shutil.copy(PROGRAM, folder / "bare")
    together = {**os.environ, "OMPI_COMM_WORLD_SIZE": "2"}
    found = shared_jobs.run(program, "run", file, "--out", folder / "refused", env=together)
    assert found.returncode == 2 and "cannot share a run by MPI" in found.stderr, found.stderr
    found = shared_jobs.run(PROGRAM, "run", file, "--shard", "1/2", "--out", folder / "refused", env=together)
    assert found.returncode == 2 and "no shard under mpirun" in found.stderr, found.stderr
    assert not (folder / "refused").exists()


def test_a_program_that_runs_alone_never_loads_mpi(folder):
    file = shared_jobs.write(shared_jobs.jobs()["compare"], folder)
    found = shared_jobs.run(PROGRAM, "validate", file, env={**os.environ, "LD_DEBUG": "libs"})
    assert "libmpi.so" not in found.stderr and "flexopt_mpi.so" not in found.stderr
    assert found.returncode == 0


def main():
    test_for = sys.argv[1:]
    if not shutil.which("mpirun"):
        print("skipped: no mpirun: install openmpi-bin and libopenmpi-dev")
        sys.exit(77)
    if not (PROGRAM.parent / "flexopt_mpi.so").exists():
        print("skipped: the program was built without MPI: install libopenmpi-dev")
        sys.exit(77)
    for name, test in list(globals().items()):
        if not name.startswith("test_") or (test_for and name not in test_for):
            continue
        folder = pathlib.Path(tempfile.mkdtemp(prefix="flexopt_mpi_"))
        begin = time.time()
        try:
            test(folder)
        finally:
            shutil.rmtree(folder, ignore_errors=True)
        print(f"{name}: {time.time() - begin:.1f} s")


if __name__ == "__main__":
    main()
