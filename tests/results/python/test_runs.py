import copy
import json
import multiprocessing
import os
import pickle
import subprocess

import flexopt
import numpy as np
import pytest
from conftest import BINARY, gallery_job


def test_an_evaluation_is_that_of_the_command_line_file_for_file(guide, tmp_path):
    job = tmp_path / "job.json"
    job.write_text(json.dumps(guide))
    subprocess.run([BINARY, "run", job, "--quiet", "--out", tmp_path / "theirs"], check=True)
    r = flexopt.evaluate(job, out=tmp_path / "ours")
    theirs = json.loads((tmp_path / "theirs/result.json").read_text())
    ours = json.loads((tmp_path / "ours/result.json").read_text())
    assert r.to_dict() == ours
    assert {**ours, "flexopt": 0} == {**theirs, "flexopt": 0}  # may be builds of two commits
    names = sorted(os.listdir(tmp_path / "theirs"))
    assert sorted(os.listdir(tmp_path / "ours")) == names
    assert (tmp_path / "ours/report.html").read_text() == r.to_html()


def test_without_a_folder_nothing_is_written(guide, hinge, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    flexopt.evaluate(guide)
    hinge["optimise"]["max_evaluations"] = 3
    flexopt.optimise(hinge)
    assert os.listdir(tmp_path) == []


def test_a_job_of_another_kind_is_evaluated_at_its_own_design(hinge):
    r = flexopt.evaluate(hinge)
    assert r.status == "ok" and r.to_dict()["job"]["job"] == "evaluate"
    assert "optimum" not in r.to_dict() or r.to_dict()["optimum"] is None


def test_an_optimisation_finds_what_the_command_line_finds(hinge, tmp_path):
    job = tmp_path / "job.json"
    job.write_text(json.dumps(hinge))
    subprocess.run([BINARY, "run", job, "--quiet", "--out", tmp_path / "theirs"], check=True)
    theirs = json.loads((tmp_path / "theirs/result.json").read_text())
    steps = []
    r = flexopt.optimise(hinge, lambda done, total, text: steps.append((done, total, text)))
    assert r.to_dict()["optimum"] == theirs["optimum"]
    assert r.status == "ok" and abs(r.objective - 256.42) < 0.03
    assert r.design["thickness"] == theirs["optimum"]["parameters"]["thickness"]
    # the objective is that of full accuracy, the path that of the job's model
    assert min(r["parasitic_frequency"]) == pytest.approx(r.objective, rel=1e-4)
    assert [c["label"] for c in r.constraints][0].startswith("max_stress")
    counted = [done for done, total, text in steps if total]
    assert counted == list(range(1, len(counted) + 1)) and len(counted) > 5


def test_a_comparison_has_the_errors_of_each_model():
    job = gallery_job("compare_parallel_guide")
    job["samples"]["count"] = 2
    job["expect"] = []
    r = flexopt.compare(job)
    assert r.status == "ok" and r.details["failed_designs"] == 0
    assert r.details["models"][0]["errors"]["support_stiffness"]["worst"] < 1e-3


def test_a_design_is_a_family_a_file_or_a_dict(guide, tmp_path):
    parts = {key: guide[key] for key in ("stroke", "end_effector", "frequencies")}
    numbers = dict(length="100 mm", width=0.03, thickness="0.5 mm", spacing="100 mm")
    by_name = flexopt.design("parallel_guide", material=guide["design"]["material"], **numbers)
    expected = flexopt.evaluate(guide)["drive_load"].tolist()
    assert flexopt.evaluate(by_name, **parts)["drive_load"].tolist() == expected
    thicker = flexopt.design(by_name, thickness="0.6 mm")
    assert flexopt.evaluate(thicker, **parts)["drive_load"][-1] > expected[-1]
    assert by_name["parameters"]["thickness"] == "0.5 mm"
    file = tmp_path / "own.json"
    exported = subprocess.run(
        [BINARY, "designs", "--export", "parallel_guide"], check=True, capture_output=True, text=True
    )
    file.write_text(exported.stdout)
    by_file = flexopt.design(file, material=guide["design"]["material"], **numbers)
    assert flexopt.evaluate(by_file, **parts)["drive_load"].tolist() == expected
    content = json.loads(exported.stdout)
    by_dict = flexopt.design(content, material=guide["design"]["material"], **numbers)
    assert flexopt.evaluate(by_dict, **parts)["drive_load"].tolist() == expected


def test_an_optimisation_without_any_design_says_so(far):
    far["design"]["parameters"]["length"] = "100 mm"
    far["optimise"]["variables"][0]["max"] = "101 mm"
    for cases in ({}, {"cases": {"a": {}, "b": {"loads": [{"force": ["1 N", 0, 0]}]}}}):
        r = flexopt.optimise({**far, **cases})
        assert r.status == "failed" and "No design could be evaluated" in r.message
        assert r.objective is None and len(r.stroke) == 0 and list(r) == [] and r.cases == {}


def test_results_can_be_compared_and_kept_in_sets(guide):
    r, other = flexopt.evaluate(guide), flexopt.evaluate(guide)
    assert r == r and r != other and len({r, other}) == 2


def test_wrong_input_tells_every_fault(guide, tmp_path):
    guide["design"]["parameters"]["length"] = "5 N"
    guide["stroke"]["to"] = "2 deg"
    with pytest.raises(flexopt.JobError) as error:
        flexopt.evaluate(guide)
    faults = error.value.faults
    assert [f.pointer for f in faults] == ["/design/parameters/length", "/stroke/to"]
    assert error.value.value == '"5 N"' and "length" in error.value.rule
    job = tmp_path / "job.json"
    job.write_text(json.dumps(guide, indent=1))
    with pytest.raises(flexopt.JobError) as error:
        flexopt.evaluate(job)
    assert error.value.faults[0].source == str(job) and error.value.faults[0].line > 3


def test_what_a_run_cannot_do_is_refused(guide, tmp_path):
    with pytest.raises(flexopt.JobError, match="optimise"):
        flexopt.optimise(guide)
    with pytest.raises(flexopt.JobError, match="expected a file|no such|missing|not"):
        flexopt.evaluate(tmp_path / "nothing.json")
    with pytest.raises(TypeError, match="frequencies"):
        flexopt.evaluate(flexopt.Job(guide), frequencies=2)
    listed = {**guide, "designs": [guide["design"], guide["design"]]}
    del listed["design"]
    with pytest.raises(flexopt.JobError):
        flexopt.evaluate(listed)


def test_a_notebook_shows_the_report(guide):
    page = flexopt.evaluate(guide)._repr_html_()
    assert page.count("<iframe srcdoc=") == 1 and "Equilibrium found at 3" in page
    assert "<script" not in page.split("srcdoc=")[1].split(" width=")[0]  # escaped


def test_a_linear_model_has_the_frequencies_and_the_compliance_of_its_point(guide):
    export = {"state_space": {"modes": 3, "damping": 0.02, "points": [1, 2]}}
    r = flexopt.evaluate(guide, export=export)
    model = r.state_space(2)
    poles = np.sort(np.abs(np.linalg.eigvals(model.A)))[::2] / (2 * np.pi)
    assert poles == pytest.approx(r.frequencies[2], rel=1e-10)
    still = model.D - model.C @ np.linalg.solve(model.A, model.B)
    load = model.inputs.index("load.ux")
    size = np.sqrt(np.outer(np.diag(r.compliance[2]), np.diag(r.compliance[2])))
    assert np.max(np.abs(still[:6, load : load + 6] - r.compliance[2]) / size) < 1e-10
    assert model.outputs[6] == "stroke"
    with pytest.raises(KeyError, match="point 0 has no linear model"):
        r.state_space(0)


def test_a_design_as_a_dict_is_a_design(guide):
    made = flexopt.design("parallel_guide", length="100 mm", width="30 mm", thickness=5e-4, spacing="100 mm", material="stavax")
    keys = {"stroke": {"to": "5 mm", "points": 2}, "end_effector": guide["end_effector"]}
    whole = flexopt.evaluate(made, **keys)["drive_load"]
    assert (flexopt.evaluate(dict(made), **keys)["drive_load"] == whole).all()
    assert (flexopt.evaluate(flexopt.Job(made, **keys))["drive_load"] == whole).all()
    with pytest.raises(flexopt.JobError, match="did you mean 'parallel_guide'"):
        flexopt.design("paralel_guide")


def test_names_of_a_design_are_checked_when_it_is_made(guide, tmp_path):
    with pytest.raises(flexopt.JobError, match="did you mean 'thickness'") as error:
        flexopt.design("parallel_guide", thicknes="0.5 mm")
    assert error.value.pointer == "/design/parameters/thicknes"
    with pytest.raises(flexopt.JobError, match="did you mean 'material'"):
        flexopt.design({**guide["design"], "materiel": "stavax"})
    own = {"flexopt_design": 1, "parameters": {"overhang": {"unit": "m"}}}
    assert flexopt.design(own)["parameters"] == {}  # values may come later
    file = tmp_path / "own.json"
    file.write_text(json.dumps(own))
    for source in (own, file):
        with pytest.raises(flexopt.JobError, match="did you mean 'overhang'"):
            flexopt.design(source, overhnag=0.1)


def test_derivatives_say_whose_they_are(guide):
    for named in ("thickness", ["thickness"], {"thickness"}, np.array(["thickness"])):
        r = flexopt.evaluate(guide, gradients=named)
        assert r.parameters == ["thickness"]
    assert len(flexopt.evaluate(guide, gradients=np.True_).parameters) > 4
    assert "With derivatives 2 of 2 leaves are full" in r.message
    assert "full" not in flexopt.evaluate(guide, gradients=None).message


def fails(job):
    return flexopt.evaluate(job)


def test_errors_go_from_process_to_process(guide):
    wrong, far = copy.deepcopy(guide), copy.deepcopy(guide)
    wrong["stroke"] = {"to": "20 xx"}
    far["stroke"] = {"to": "130 mm", "points": 4}
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        with pytest.raises(flexopt.JobError) as refused:
            pool.map(fails, [wrong])
        with pytest.raises(flexopt.NotConverged) as ended:
            pool.map(fails, [far])
    assert refused.value.pointer == "/stroke/to" and refused.value.faults[0].value == '"20 xx"'
    assert 0 < ended.value.stroke < 0.13 and ended.value.result is None
    assert copy.copy(refused.value).faults == refused.value.faults
    assert pickle.loads(pickle.dumps(flexopt.NoGradient("why"))).args == ("why",)
