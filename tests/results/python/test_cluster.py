"""The example of docs/cluster.md, on workers of this machine."""

import os
import re
import subprocess
import sys

import pytest
from conftest import SOURCE

PAGE = (SOURCE / "docs/cluster.md").read_text()


@pytest.fixture
def script(tmp_path):
    pytest.importorskip("distributed")
    (code,) = re.findall(r"```python\n(.*?)```", PAGE, re.S)
    file = tmp_path / "guides.py"
    file.write_text(code)
    return file


def test_workers_return_the_numbers_of_one_process(script):
    environment = {**os.environ, "DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT": "60s"}
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=300,
                          cwd=script.parent, env=environment)
    assert done.returncode == 0, done.stderr
    names = {"__name__": "guides"}
    exec(compile(script.read_text(), str(script), "exec"), names)
    rows = [line.split() for line in done.stdout.splitlines()]
    assert len(rows) == 10
    for thickness, stiffness in rows:
        assert float(stiffness) == names["stiffness"](float(thickness))
    assert len({stiffness for _, stiffness in rows}) == 10
