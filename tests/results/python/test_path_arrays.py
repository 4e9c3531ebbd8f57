import gc

import flexopt
import numpy as np
import pytest
from conftest import SOURCE, gallery_job


def in_result(point, name):
    """The number of a quantity in a point of result.json."""
    entry = point
    for key in name.split("."):
        if isinstance(entry, list):
            entry = entry["xyz".index(key)] if key in "xyz" else entry[int(key)]
        elif key == "moving" and "moving" not in entry:
            return None
        else:
            entry = entry[key]
    return entry["value"] if isinstance(entry, dict) else entry


def test_arrays_hold_the_numbers_of_the_result_to_the_bit(guide):
    r = flexopt.evaluate(guide)
    path = r.to_dict()["path"]
    assert len(r) > 30
    for name in r:
        assert [in_result(point, name) for point in path] == r[name].tolist(), name
    assert r.stroke.tolist() == [point["stroke"] for point in path]
    for name, array in (("drive_free", r.compliance), ("drive_locked", r.compliance_locked)):
        assert array.tolist() == [point["compliance"][name] for point in path]
    for name, array in (("drive_free", r.frequencies), ("drive_locked", r.frequencies_locked)):
        assert array.tolist() == [point["frequencies"][name] for point in path]
    assert r.displacement.tolist() == [point["displacement"] for point in path]
    assert r.rotation.tolist() == [point["rotation"] for point in path]


def test_arrays_are_views_that_outlive_their_result_and_cannot_be_written(guide):
    r = flexopt.evaluate(guide)
    arrays = [r.stroke, r.compliance, r.frequencies, r["drive_load"], r["support_stiffness.uz"]]
    assert np.shares_memory(r["drive_load"], r["drive_load"])
    assert np.shares_memory(r.compliance, r.compliance)
    before = [array.copy() for array in arrays]
    del r
    gc.collect()
    again = flexopt.evaluate(guide, stroke={"from": 0, "to": "10 mm", "points": 3})
    assert again["drive_load"][-1] != before[3][-1]
    for array, copy in zip(arrays, before):
        assert not array.flags.writeable and not array.flags.owndata
        assert (array == copy).all()


def test_a_quantity_that_is_none_or_has_no_number_is_a_key_error(guide):
    r = flexopt.evaluate(guide, gradients=["thickness"])
    for name in ("nothing", "support_stiffness.uy", "notch_stress"):
        assert name not in r and r.get(name) is None and name not in r.gradients
        with pytest.raises(KeyError):
            r[name]
        with pytest.raises(KeyError):
            r.gradient(name)


def test_points_without_equilibrium_are_masked_and_tell_how_far_the_path_came():
    with pytest.raises(flexopt.NotConverged) as error:
        flexopt.evaluate(SOURCE / "tests/results/report/jobs/stops_early.json")
    r = error.value.result
    assert error.value.stroke == r.stroke[1]
    assert r.converged.tolist() == [True, True, False, False]
    assert r["drive_load"].mask.tolist() == [False, False, True, True]
    assert r.frequencies.mask.all(axis=1).tolist() == [False, False, True, True]
    for array in (r.displacement, r.rotation, r.compliance, r.compliance_locked):
        assert array.mask.reshape(4, -1).all(axis=1).tolist() == [False, False, True, True]
        assert not array.mask[:2].any() and not array[:2].data.flags.writeable
    assert r.stroke_reached == r.stroke[1]
    assert "no equilibrium" in r.messages[2] and r.status == "no_equilibrium"


def differences(job, parameter, names):
    """Central differences of differentiable paths."""

    def at(step):
        own = {**job, "design": {**job["design"], "parameters": dict(job["design"]["parameters"])}}
        value = flexopt.Job(job).parameters[parameter]
        own["design"]["parameters"][parameter] = value * (1 + step)
        return value, flexopt.evaluate(own, gradients=[parameter])

    (value, above), (_, below) = at(1e-4), at(-1e-4)
    return {name: (above[name] - below[name]) / (2e-4 * value) for name in names}


@pytest.mark.parametrize("parameter", ["thickness", "inner_width"])
def test_gradients_are_differences_also_where_a_formula_follows(hinge, parameter):
    hinge["stroke"] = {"from": 0, "to": "10 deg", "points": 2}
    names = ["drive_load", "support_stiffness.uy", "parasitic_frequency", "leaf_mass"]
    exact = flexopt.evaluate(hinge, gradients=[parameter])
    for name, slope in differences(hinge, parameter, names).items():
        found = exact.gradients[name][parameter]
        scale = np.abs(slope).max()
        assert found.shape == (2,)
        # the differences: 1e-8 of their step, and rounding of paths known to 1e-9
        assert np.abs(found - slope).max() <= 2e-5 * scale + 1e-12, (name, found, slope)


def test_gradients_are_by_every_parameter_or_by_those_named(guide):
    job = flexopt.Job(guide)
    r = flexopt.evaluate(job, gradients=True)
    assert r.parameters == job.differentiable
    assert r.gradient("drive_load").shape == (3, len(job.differentiable))
    some = flexopt.evaluate(job, gradients=["width", "material.density"])
    by_width = r.gradients["drive_load"]["width"]
    np.testing.assert_allclose(some.gradients["drive_load"]["width"], by_width, rtol=1e-9, atol=1e-9)
    with pytest.raises(flexopt.JobError, match="expected some of"):
        flexopt.evaluate(job, gradients=["colour"])
    with pytest.raises(flexopt.NoGradient):
        flexopt.evaluate(job).gradient("drive_load")


def test_load_cases_have_paths_of_their_own():
    job = gallery_job("load_cases")
    del job["tolerances"], job["tolerance_samples"], job["expect"]
    r = flexopt.evaluate(job)
    cases = r.to_dict()["cases"]
    assert list(r.cases) == ["hanging", "standing"]
    for name, path in r.cases.items():
        assert path["drive_load"].tolist() == [p["drive_load"] for p in cases[name]["path"]]
    assert (r["drive_load"] == r.cases["hanging"]["drive_load"]).all()


def test_strokes_of_several_drives_stand_under_their_names(guide):
    r = flexopt.evaluate(gallery_job("xy_stage"))
    points = r.to_dict()["path"]
    assert list(r.strokes) == ["x", "y"]
    for name, values in r.strokes.items():
        assert values.tolist() == [point["stroke"][name] for point in points]
    assert flexopt.evaluate(guide).strokes == {}
    pytest.importorskip("pandas")
    assert r.to_pandas()["stroke.y"].tolist() == r.strokes["y"].tolist()


def test_tables_have_the_same_numbers(guide):
    pytest.importorskip("pandas")
    pytest.importorskip("xarray")
    r = flexopt.evaluate(guide)
    frame, dataset = r.to_pandas(), r.to_xarray()
    assert frame["max_stress"].tolist() == r["max_stress"].tolist()
    assert frame.index.tolist() == r.stroke.tolist()
    assert dataset["drive_stiffness"].attrs["units"] == "N/m"
    assert dataset["compliance"].sel(motion="uz", load="uz").values.tolist() == r.compliance[:, 2, 2].tolist()
