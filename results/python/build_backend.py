"""What pip calls: CMake builds the module, and its package becomes a wheel. Without other packages."""

import base64
import hashlib
import os
import pathlib
import re
import subprocess
import sys
import sysconfig
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "results/python/flexopt"
VERSION = re.search(r"project\(flexopt VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text())[1]
INFO = f"flexopt-{VERSION}.dist-info"
METADATA = f"""Metadata-Version: 2.1
Name: flexopt
Version: {VERSION}
Summary: Evaluates and optimises flexure mechanisms: leaf-spring guides and hinges that bend far
License: MIT
Requires-Python: >=3.9
Requires-Dist: numpy
"""


def _built_module():
    """Of the Python that runs this, in a build folder of its own."""
    build = ROOT / "build/wheel"
    configure = [
        "cmake", "--preset", "release", "-B", build, "-D", "FLEXOPT_PYTHON=ON",
        "-D", "FLEXOPT_TESTS=OFF", "-D", f"Python_EXECUTABLE={sys.executable}",
    ]  # fmt: skip
    subprocess.run(configure, cwd=ROOT, check=True)
    subprocess.run(["cmake", "--build", build, "--target", "flexopt_python"], cwd=ROOT, check=True)
    suffix = sysconfig.get_config_var("EXT_SUFFIX")
    return build / "python/flexopt" / f"_core{suffix}"


def _files(module):
    """(name in the wheel, content)"""
    sources = [*PACKAGE.glob("*.py"), *PACKAGE.glob("*.pyi"), PACKAGE / "py.typed"]
    for path in sorted([*sources, module]):
        yield f"flexopt/{path.name}", path.read_bytes()
    yield f"{INFO}/METADATA", METADATA.encode()
    yield f"{INFO}/WHEEL", f"Wheel-Version: 1.0\nRoot-Is-Purelib: false\nTag: {_tag()}\n".encode()
    yield f"{INFO}/licenses/LICENSE", (ROOT / "LICENSE").read_bytes()


def _tag():
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    platform = re.sub(r"[-.]", "_", sysconfig.get_platform())
    return f"{python}-{python}-{platform}"


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    name = f"flexopt-{VERSION}-{_tag()}.whl"
    record = []
    with zipfile.ZipFile(os.path.join(wheel_directory, name), "w", zipfile.ZIP_DEFLATED) as wheel:
        for path, content in _files(_built_module()):
            wheel.writestr(path, content)
            digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
            record.append(f"{path},sha256={digest},{len(content)}")
        wheel.writestr(f"{INFO}/RECORD", "\n".join([*record, f"{INFO}/RECORD,,", ""]))
    return name
