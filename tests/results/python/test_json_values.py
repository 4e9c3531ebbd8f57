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
    keys = {"stroke": {"at": np.array([0, 0.01])}, "frequencies": np.int64(3), "expect": []}
    assert flexopt.Job(gallery("parallel_guide"), **keys).to_dict() == plain


def test_numbers_of_more_bits_are_the_nearest_ones():
    sizes = {"length": 0.1, "width": 0.03, "spacing": 0.1, "material": "stavax"}
    for thickness in (np.longdouble(5e-4), np.array(5e-4, np.longdouble), np.clongdouble(5e-4)):
        job = flexopt.Job(flexopt.design("parallel_guide", thickness=thickness, **sizes), stroke={"at": [0]})
        assert job.parameters["thickness"] == 5e-4


@pytest.mark.parametrize(
    "value, rule", [(object(), "JSON"), (float("nan"), "finite"), ({1: 2}, "texts"), (1 << 70, "63")]
)
def test_what_json_does_not_have_is_refused_with_its_place(guide, value, rule):
    guide["end_effector"]["mass"] = value
    with pytest.raises(flexopt.JobError) as error:
        flexopt.Job(guide)
    assert error.value.pointer == "/end_effector/mass"
    assert rule in error.value.rule


def test_what_has_no_end_is_refused(guide):
    round_about = {}
    round_about["again"] = round_about
    endless, deep = [], []
    endless.append(endless)
    for _ in range(100000):
        deep = [deep]
    for value in (round_about, endless, deep, "\udcff", np.clongdouble(1j)):
        guide["end_effector"]["mass"] = value
        with pytest.raises(flexopt.JobError) as error:
            flexopt.Job(guide)
        assert error.value.pointer.startswith("/end_effector/mass")


def test_a_result_has_the_types_of_its_json(guide):
    result = flexopt.evaluate(guide).to_dict()
    assert isinstance(result["path"], list) and isinstance(result["path"][0], dict)
    assert result["path"][0]["status"] == "converged" and result["path"][0]["stable"] is True
    assert result["path"][0]["support_stiffness"].get("uy") is None
