import pathlib

import flexopt
import numpy as np
import pytest
from conftest import gallery, gallery_job


def test_a_dict_is_the_job_of_the_file_with_the_same_json():
    for name in ("parallel_guide", "load_cases", "xy_stage"):
        assert flexopt.Job(gallery_job(name)).to_dict() == flexopt.Job(gallery(name)).to_dict()


def test_numbers_of_numpy_tuples_and_paths_stand_for_those_of_json(guide, tmp_path):
    plain = flexopt.Job({**guide, "stroke": {"at": [0.0, 0.01]}}).to_dict()
    guide["stroke"] = {"at": np.array([0, 0.01])}
    guide["frequencies"] = np.int64(3)
    guide["end_effector"]["inertia"] = tuple(guide["end_effector"]["inertia"])
    assert flexopt.Job(guide).to_dict() == plain
    named = flexopt.Job({**guide, "name": pathlib.Path("a/b")})
    assert named.name == "a/b"


@pytest.mark.parametrize(
    "value, rule", [(object(), "JSON"), (float("nan"), "finite"), ({1: 2}, "texts"), (1 << 70, "63")]
)
def test_what_json_does_not_have_is_refused_with_its_place(guide, value, rule):
    guide["end_effector"]["mass"] = value
    with pytest.raises(flexopt.JobError) as error:
        flexopt.Job(guide)
    assert error.value.pointer == "/end_effector/mass"
    assert rule in error.value.rule


def test_a_result_has_the_types_of_its_json(guide):
    result = flexopt.evaluate(guide).to_dict()
    assert isinstance(result["path"], list) and isinstance(result["path"][0], dict)
    assert result["path"][0]["status"] == "converged" and result["path"][0]["stable"] is True
    assert result["path"][0]["support_stiffness"].get("uy") is None
