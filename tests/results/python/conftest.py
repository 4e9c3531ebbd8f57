"""What the tests of the Python module share. FLEXOPT_BINARY: the program; FLEXOPT_SOURCE: the sources."""

import json
import os
import pathlib

import pytest

SOURCE = pathlib.Path(os.environ["FLEXOPT_SOURCE"])
BINARY = os.environ["FLEXOPT_BINARY"]


def gallery(name):
    return SOURCE / "designs/jobs" / f"{name}.json"


def gallery_job(name):
    return json.loads(gallery(name).read_text())


@pytest.fixture
def guide():
    """A small evaluation."""
    job = gallery_job("parallel_guide")
    job.update(stroke={"from": 0, "to": "20 mm", "points": 3}, frequencies=3, expect=[])
    return job


@pytest.fixture
def hinge():
    """An optimisation with a formula among its parameters."""
    job = gallery_job("three_flexure_cross_hinge")
    job["expect"] = []
    job["optimise"]["starts"] = 1
    return job


@pytest.fixture
def far():
    """An optimisation that starts at a guide which reaches its stroke; those below 0.2 m do not."""
    sizes = {"length": "250 mm", "width": "30 mm", "thickness": "0.5 mm", "spacing": "100 mm"}
    return {
        "flexopt": 1,
        "name": "pulled far",
        "job": "optimise",
        "design": {"family": "parallel_guide", "material": "stavax", "parameters": sizes},
        "end_effector": {"mass": "1 kg", "inertia": ["1e-3 kg m^2"] * 3},
        "stroke": {"from": 0, "to": "160 mm", "points": 4},
        "optimise": {
            "variables": [{"parameter": "length", "min": "100 mm", "max": "300 mm"}],
            "objective": {"minimise": "drive_load", "over_stroke": "max_abs"},
        },
    }
