"""The scripts of docs/cluster on a Slurm of one machine, which this test starts and stops.

Needs slurmctld, slurmd, munged and root; exit code 77, "skipped", where one of them is missing.
"""

import os
import pathlib
import shutil
import socket
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
import shared_jobs  # noqa: E402

SOURCE, PROGRAM = pathlib.Path(os.environ["FLEXOPT_SOURCE"]), os.environ["FLEXOPT_BINARY"]
os.environ["PATH"] += ":/usr/sbin:/sbin"


def skip(why):
    print("skipped:", why)
    sys.exit(77)


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def wait(what, seconds, ready):
    end = time.time() + seconds
    while not ready():
        if time.time() > end:
            raise AssertionError(f"{what} not within {seconds} s")
        time.sleep(0.1)


class Slurm:
    """munged, slurmctld and slurmd with all their files in one folder."""

    def __init__(self, folder):
        self.folder, self.started = folder, []
        self.environment = {**os.environ, "SLURM_CONF": str(folder / "slurm.conf")}

    def start(self, *command):
        with open(self.folder / f"{pathlib.Path(command[0]).name}.out", "w") as out:
            self.started.append(subprocess.Popen([str(word) for word in command], stdout=out, stderr=out,
                                                 env=self.environment))

    def __enter__(self):
        folder, host = self.folder, socket.gethostname().split(".")[0]
        key, munge = folder / "munge.key", folder / "munge.socket"
        key.write_bytes(os.urandom(128))
        key.chmod(0o600)
        for name in ("state", "spool"):
            (folder / name).mkdir()
        (folder / "slurm.conf").write_text(f"""
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={free_port()}
SlurmdPort={free_port()}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={munge}
CredType=cred/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=2,bf_interval=2,batch_sched_delay=0
ReturnToService=2
NodeName={host} NodeAddr=127.0.0.1 CPUs={os.cpu_count()} State=UNKNOWN
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP
""")
        try:
            self.start("munged", "--foreground", "--force", f"--key-file={key}", f"--socket={munge}",
                       f"--pid-file={folder}/munge.pid", f"--log-file={folder}/munge.log",
                       f"--seed-file={folder}/munge.seed")
            wait("munge", 10, munge.exists)
            self.start("slurmctld", "-D")
            self.start("slurmd", "-D", "-N", host)
            wait("a node that is idle", 60, lambda: "idle" in self.ask("sinfo", "-h", "-o", "%T"))
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        for process in reversed(self.started):
            process.terminate()
            try:
                process.wait(15)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()

    def ask(self, *command, **environment):
        found = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=30,
                               cwd=self.folder, env={**self.environment, **environment})
        return found.stdout + found.stderr

    def submit(self, *arguments, **environment):
        """The number of the job."""
        said = self.ask("sbatch", "--parsable", *arguments, **environment)
        assert said.strip().isdigit(), said
        return said.strip()

    def ended(self, number):
        wait(f"the end of job {number}", 120,
             lambda: not self.ask("squeue", "-h", "-j", number, "-t", "PD,R,CG").strip())


def words(file):
    return file.read_text(errors="replace")[-1500:] if file.exists() else ""


def test(folder):
    job = shared_jobs.jobs()["compare"]
    file = shared_jobs.write(job, folder)
    alone = shared_jobs.run(PROGRAM, "run", file, "--quiet", "--out", folder / "alone")
    assert alone.returncode == 0, alone.stderr
    scripts = SOURCE / "docs/cluster"
    (folder / "slurm").mkdir()
    with Slurm(folder / "slurm") as slurm:
        few = {"SHARDS": "4", "FLEXOPT": PROGRAM}
        # one task is left out, as if it had been killed in the queue
        array = slurm.submit("--array=1,2,4", scripts / "array.sbatch", file, folder / "out", **few)
        slurm.ended(array)
        told = shared_jobs.run(PROGRAM, "merge", *sorted((folder / "out.shards").iterdir()), "--out",
                               folder / "out")
        assert told.returncode == 2 and "--array=3" in told.stderr, told.stderr
        again = slurm.submit("--array=3", scripts / "array.sbatch", file, folder / "out", **few)
        merge = slurm.submit(f"--dependency=afterok:{again}", scripts / "merge.sbatch", folder / "out", **few)
        slurm.ended(merge)
        for log in sorted((folder / "slurm").glob("*.sbatch.*.log")):
            print(log.name, words(log))
    found = shared_jobs.differences(folder / "alone", folder / "out")
    assert not found, f"other bytes than those of one process: {found}"


def main():
    for program in ("munged", "slurmctld", "slurmd", "sbatch"):
        if not shutil.which(program):
            skip(f"no {program}: install slurmctld, slurmd, slurm-client and munge")
    if os.geteuid() != 0:
        skip("Slurm is started by root alone")
    folder = pathlib.Path(tempfile.mkdtemp(prefix="flexopt_slurm_"))
    try:
        test(folder)
    except BaseException:
        for log in ("munge.log", "munged.out", "slurmctld.log", "slurmctld.out", "slurmd.log", "slurmd.out"):
            print("---", log, words(folder / "slurm" / log), sep="\n")
        raise
    finally:
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main()
