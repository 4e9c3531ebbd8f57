"""Every example of docs/python.md runs, one after the other, and does what it says."""

import re
import sys
import types

import pytest
from conftest import SOURCE

PAGE = (SOURCE / "docs/python.md").read_text()


class Component:
    """What the example needs of OpenMDAO's ExplicitComponent."""

    def __init__(self):
        self.inputs, self.outputs = {}, {}
        self.setup()

    def add_input(self, name, value):
        self.inputs[name] = [value]

    def add_output(self, name, value=0.0):
        self.outputs[name] = value

    def declare_partials(self, of, wrt):
        pass


@pytest.fixture(scope="module")
def page():
    """The names that the examples leave."""
    api = types.ModuleType("openmdao.api")
    api.ExplicitComponent = Component
    api.AnalysisError = type("AnalysisError", (Exception,), {})
    sys.modules.setdefault("openmdao", types.ModuleType("openmdao"))
    sys.modules["openmdao.api"] = api
    pytest.importorskip("scipy")
    pytest.importorskip("pandas")
    names = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(SOURCE)
        for code in re.findall(r"```python\n(.*?)```", PAGE, re.S):
            exec(compile(code, "docs/python.md", "exec"), names)
        names["component"] = names["Hinge"]()
    return names


def test_the_examples_find_the_optimum_of_the_readme(page):
    assert abs(page["hinge"].objective - 256.42) < 0.03
    assert page["p"].objective(page["found"].x) == pytest.approx(page["hinge"].objective, rel=1e-4)
    assert page["best"].objective == page["hinge"].objective
    assert page["found"].nfev <= 2 * int(re.search(r"needs (\d+) evaluations", PAGE)[1])


def test_the_evaluation_has_the_shapes_that_the_page_tells(page):
    r = page["r"]
    assert r["drive_load"].shape == (11,) and r.compliance.shape == (11, 6, 6)
    assert r.frequencies.shape == (11, 6)
    assert r.gradients["drive_load"]["thickness"].shape == (11,)
    assert page["table"].shape[0] == 11


def test_the_component_has_the_goals_and_their_derivatives(page):
    component, partials = page["component"], {}
    component.compute(component.inputs, component.outputs)
    component.compute_partials(component.inputs, partials)
    before = component.outputs["f"]
    step = 1e-7
    component.inputs["thickness"] = [component.inputs["thickness"][0] + step]
    component.compute(component.inputs, component.outputs)
    assert (component.outputs["f"] - before) / step == pytest.approx(partials["f", "thickness"], rel=2e-3)
    component.inputs["thickness"] = [-1.0]
    with pytest.raises(sys.modules["openmdao.api"].AnalysisError):
        component.compute(component.inputs, component.outputs)


def test_the_careful_function_gives_what_is_worse_where_there_is_nothing(page):
    p = page["p"]
    f = page["careful"](p)
    assert f(p.x0) == p.f(p.x0)

    class Failing:
        def f(self, x):
            raise page["flexopt"].NotConverged("no equilibrium")

    assert page["careful"](Failing())(p.x0) == 1


def test_the_page_names_every_call_and_property():
    import flexopt

    for name in set(flexopt.__all__) - {"Design", "Fault", "Gradients", "Path", "Progress", "Result"}:
        assert name in PAGE, name
    for name in dir(flexopt.Optimum) + dir(flexopt.Problem):
        public = not name.startswith("_") and name not in dir(dict) + ["folder", "failed_expectations"]
        assert not public or name in PAGE, name
