import os
import signal
import subprocess
import sys
import textwrap
import threading
import time

import flexopt
import pytest


def test_the_interpreter_goes_on_while_a_run_computes(hinge):
    """Nothing else could count if the run kept the lock: the callback's own turns are left out."""
    counted, ended = [], threading.Event()
    others = threading.Thread(target=lambda: [counted.append(time.sleep(0.002)) for _ in iter(ended.is_set, True)])
    others.start()
    flexopt.optimise(hinge)
    ended.set()
    others.join()
    assert len(counted) > 50


def test_control_c_ends_a_run_which_the_next_call_goes_on_with(hinge, tmp_path):
    hinge["optimise"]["starts"] = 3
    seen = []

    def progress(done, total, text):
        seen.append(done)
        if done == 4:
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        flexopt.optimise(hinge, progress, out=tmp_path / "out", threads=2)
    logged = (tmp_path / "out/evaluations.jsonl").read_text().count("\n") - 1
    assert logged >= 4 and not (tmp_path / "out/result.json").exists()
    texts = []
    whole = flexopt.optimise(hinge, lambda d, n, text: texts.append(text), out=tmp_path / "out")
    assert any(f"{logged} from the log" in text for text in texts), texts[-1]
    assert whole.to_dict() == flexopt.optimise(hinge).to_dict()


def test_an_error_of_the_callback_ends_the_run_and_comes_out(hinge, guide):
    class Enough(Exception):
        pass

    steps = []

    def progress(done, total, text):
        steps.append(done)
        if done == 2 or "evaluating" in text:
            raise Enough

    for threads in (1, 2):
        with pytest.raises(Enough):
            flexopt.optimise(hinge, progress, threads=threads)
    assert max(steps) == 2
    with pytest.raises(Enough):
        flexopt.evaluate(guide, progress=progress)


def test_an_error_of_the_callback_ends_a_comparison_at_once():
    from conftest import gallery_job

    job = gallery_job("compare_parallel_guide")
    done = []

    def progress(k, total, text):
        done.append(k)
        if k:
            raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        flexopt.compare(job, progress, threads=1)
    assert max(done) == 1


@pytest.mark.parametrize("call", ["evaluate", "optimise"])
def test_python_ends_while_a_thread_computes(hinge, call):
    script = f"""
        import threading, time, flexopt
        def compute():
            while True:
                flexopt.{call}({hinge!r})
        threading.Thread(target=compute, daemon=True).start()
        time.sleep(0.3)
    """
    for _ in range(3):
        done = subprocess.run([sys.executable, "-c", textwrap.dedent(script)], timeout=120, capture_output=True)
        assert done.returncode == 0 and done.stderr == b""
