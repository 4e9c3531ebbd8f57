"""What pip installs: the module of this build as a wheel."""

import pathlib
import subprocess
import sys
import zipfile

import pytest
from flexopt import _core
from conftest import SOURCE


def test_the_wheel_is_whole_and_installs_without_the_network(tmp_path, monkeypatch):
    pytest.importorskip("pip")
    monkeypatch.syspath_prepend(str(SOURCE / "results/python"))
    import build_backend

    monkeypatch.setattr(build_backend, "_built_module", lambda: pathlib.Path(_core.__file__))
    name = build_backend.build_wheel(tmp_path)
    with zipfile.ZipFile(tmp_path / name) as content:
        names = content.namelist()
    for source in (SOURCE / "results/python/flexopt").iterdir():
        assert f"flexopt/{source.name}" in names or source.name == "__pycache__"
    target = tmp_path / "installed"
    subprocess.run(
        [sys.executable, "-m", "pip", "install", "--quiet", "--no-index", "--no-deps",
         "--target", target, tmp_path / name],
        check=True,
    )
    script = "import flexopt; print(flexopt.__file__, flexopt.__version__)"
    shown = subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path, env={"PYTHONPATH": str(target)},
        check=True, capture_output=True, text=True,
    ).stdout
    assert shown.split() == [str(target / "flexopt/__init__.py"), _core.version]
