import concurrent.futures

import flexopt
import numpy as np
import pytest


def differences(function, x, steps):
    columns = []
    for j, step in enumerate(steps):
        shift = np.zeros(len(x))
        shift[j] = step
        columns.append((function(x + shift) - function(x - shift)) / (2 * step))
    return np.array(columns).T


@pytest.mark.parametrize("scaled", [True, False])
@pytest.mark.parametrize("pointwise", [True, False])
def test_derivatives_are_differences(hinge, scaled, pointwise):
    p = flexopt.Problem(hinge, scaled=scaled, pointwise=pointwise)
    steps = 1e-4 * np.where(np.isfinite(p.upper - p.lower), p.upper - p.lower, 1)
    df, dg = p.jac(p.x0)
    f, g = differences(p.f, p.x0, steps), differences(p.g, p.x0, steps)
    # curvature over the step: 1e-8 of the range; paths known to 1e-9
    assert np.abs((df - f) * steps).max() <= 1e-8 + 1e-4 * np.abs(f * steps).max()
    assert dg.shape == (len(p.g_names), len(p.names))
    goals, at = [name.split(" [")[0] for name in p.g_names], np.abs(p.g(p.x0))
    largest = np.array([max(at[k] for k, other in enumerate(goals) if other == goal) for goal in goals])
    of_row = 1e-8 * (1 + largest) + 2e-4 * np.abs(g * steps).max(axis=1)
    assert (np.abs((dg - g) * steps).max(axis=1) <= of_row).all()


def test_the_forms_say_the_same_of_a_design(hinge):
    plain, si = flexopt.Problem(hinge), flexopt.Problem(hinge, scaled=False)
    many = flexopt.Problem(hinge, pointwise=True)
    x = np.array([0.4, 0.3, 0.5, 0.4])
    assert si.names == ["length", "thickness", "half_angle", "inner_width"]
    in_si = si.lower + x * (si.upper - si.lower)
    assert plain.objective(x) == pytest.approx(si.objective(in_si), rel=1e-9)
    assert -si.f(in_si) == pytest.approx(plain.objective(x), rel=1e-9)
    assert si.g(in_si)[0] == pytest.approx(plain.g(x)[0] * 450e6, rel=1e-9)
    t = plain.objective(x) / plain.objective(plain.x0)
    g = many.g(np.append(x, t))
    rows = [k for k, name in enumerate(many.g_names) if name.startswith("objective [")]
    assert many.names[-1] == "t" and many.f(np.append(x, t)) == -t
    assert g[rows].min() == pytest.approx(0, abs=1e-6)
    stress = [k for k, name in enumerate(many.g_names) if name.startswith("max_stress")]
    assert g[stress].max() == pytest.approx(plain.g(x)[0], rel=1e-9)
    assert plain.parameters(x)["outer_width"] == pytest.approx((0.098 - in_si[3]) / 2)


@pytest.mark.parametrize("pointwise, method, options, most", [
    (True, "SLSQP", {"ftol": 1e-9, "maxiter": 200}, 40),
    (False, "SLSQP", {"ftol": 1e-9, "maxiter": 200}, 600),
    (True, "trust-constr", {"maxiter": 60}, None),  # as near as after 120, in less than half the time
])
def test_methods_of_scipy_find_the_optimum(hinge, pointwise, method, options, most):
    optimize = pytest.importorskip("scipy.optimize")
    p = flexopt.Problem(hinge, pointwise=pointwise)
    limits = optimize.NonlinearConstraint(p.g, p.g_lower, p.g_upper, jac=p.dg)
    found = optimize.minimize(p.f, p.x0, jac=p.df, bounds=p.bounds, constraints=[limits], method=method,
                              options=options)
    assert p.objective(found.x) == pytest.approx(256.42, abs=0.03)
    if most:
        assert found.success and found.nfev <= most
        assert p.parameters(found.x)["thickness"] == pytest.approx(4.01e-4, abs=3e-6)
    else:
        assert found.constr_violation < 1e-6


def test_a_design_without_values_tells_how_far_its_path_came(far):
    p = flexopt.Problem(far, scaled=False)
    assert np.isfinite(p.f([0.25]))
    with pytest.raises(flexopt.NotConverged) as error:
        p.df([0.1])
    assert error.value.stroke == pytest.approx(0.16 / 3)
    with pytest.raises(flexopt.NotConverged) as error:
        p.f([-1.0])
    assert error.value.stroke is None and "/design/parameters/length" in str(error.value)


def test_wrong_numbers_are_refused(hinge, guide):
    p = flexopt.Problem(hinge)
    for x in ([0.5, 0.5], [np.nan] * 4):
        with pytest.raises(flexopt.JobError):
            p.f(x)
    with pytest.raises(flexopt.JobError, match="/optimise"):
        flexopt.Problem(guide)


def test_threads_share_a_problem(hinge):
    p = flexopt.Problem(hinge)
    xs = [np.full(4, 0.3 + 0.02 * k) for k in range(6)]
    alone = [flexopt.Problem(hinge).f(x) for x in xs]
    with concurrent.futures.ThreadPoolExecutor(len(xs)) as pool:
        found = list(pool.map(p.f, xs))
    assert found == alone


@pytest.mark.parametrize("scaled", [True, False])
def test_beyond_its_bounds_a_design_is_taken_as_it_is(hinge, scaled):
    p = flexopt.Problem(hinge, scaled=scaled)
    step = np.zeros(4)
    step[3] = 1e-5 * (p.upper - p.lower)[3]
    x = p.x0.copy()
    x[3] = p.lower[3]
    df = p.df(x)
    assert p.parameters(x - step)["inner_width"] < p.parameters(x)["inner_width"]
    assert p.f(x + step) - p.f(x - step) == pytest.approx(2 * df @ step, rel=1e-3)


def test_a_design_without_derivatives_says_so(guide):
    guide["design"]["parameters"]["thickness"] = {"expression": "0.5 mm + 0.01*sqrt((width - 30 mm)*1 mm)"}
    guide["design"]["parameters"]["width"] = "30 mm"
    guide.update(job="optimise", optimise={
        "variables": [{"parameter": "width", "min": "30 mm", "max": "40 mm"}],
        "objective": {"maximise": "support_stiffness.uz", "over_stroke": "min"}})
    p = flexopt.Problem(guide)
    assert np.isfinite(p.f(p.x0))
    with pytest.raises(flexopt.NoGradient, match="has no derivative"):
        p.df(p.x0)
