"""What runs return."""

from __future__ import annotations

import functools
import html
import importlib
from typing import Any, Iterator, Mapping, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._errors import NoGradient

Array = NDArray[np.float64]
_ma: Any = np.ma  # its functions have no types


def _masked(numbers: Array, missing: NDArray[np.bool_] | None) -> Array:
    if missing is None:
        return numbers
    masked: Array = _ma.MaskedArray(numbers, mask=missing)
    return masked


class StateSpace(NamedTuple):
    """dx/dt = A x + B u, y = C x + D u; x: modal amplitudes, then their velocities."""

    A: Array
    B: Array
    C: Array
    D: Array
    inputs: list[str]
    outputs: list[str]


class Gradients(Mapping[str, Mapping[str, Array]]):
    """``gradients[quantity][parameter]``: n derivatives, SI per SI."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def __getitem__(self, quantity: str) -> Mapping[str, Array]:
        rows = self._path.gradient(quantity)
        return {name: rows[:, j] for j, name in enumerate(self._path.parameters)}

    def __iter__(self) -> Iterator[str]:
        return iter(self._path.names)

    def __len__(self) -> int:
        return len(self._path.names)


class Path(Mapping[str, Array]):
    """One load case over its stroke of n points: ``path[quantity]`` has n numbers, SI.

    Arrays are read-only views of the memory of the evaluation. Where a point has no such number
    (no equilibrium, no parasitic mode) they are masked arrays.
    """

    _run: _core.Run
    _case = 0

    def __init__(self, run: _core.Run, case: int, parameters: list[str]) -> None:
        self._run = run
        self._case = case
        #: What gradients are by: the columns of ``gradient``.
        self.parameters = parameters

    @functools.cached_property
    def _arrays(self) -> _core.Path:
        return self._run.path(self._case)

    def __getitem__(self, quantity: str) -> Array:
        return _masked(*self._arrays.values(quantity))

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.names)

    def __contains__(self, quantity: object) -> bool:
        return quantity in self.names

    def __eq__(self, other: object) -> bool:
        return self is other

    def __hash__(self) -> int:
        return id(self)

    @functools.cached_property
    def names(self) -> list[str]:
        """Quantities with a number at some point."""
        return self._arrays.names

    @property
    def units(self) -> dict[str, str]:
        """SI unit of each quantity."""
        return self._arrays.units

    @property
    def status(self) -> str:
        """``ok``, ``no_equilibrium``, ``left_branch``, or ``limit_reached`` (the job's ``limits``)."""
        return self._arrays.status

    @property
    def message(self) -> str:
        return self._arrays.message

    @property
    def messages(self) -> list[str]:
        """Of each point: why it has no equilibrium."""
        return self._arrays.messages

    @property
    def stroke_reached(self) -> float | None:
        """How far it came from its start [m or rad]; None where it did not begin."""
        return self._arrays.stroke_reached

    @property
    def converged(self) -> NDArray[np.bool_]:
        """(n,)"""
        return self._arrays.converged

    @property
    def stroke(self) -> Array:
        """(n,) [m or rad], of the first drive"""
        return self._arrays.stroke

    @property
    def strokes(self) -> dict[str, Array]:
        """Of drives with names: (n,) [m or rad] of each. Empty for one without, and on load paths."""
        return self._arrays.strokes

    @property
    def displacement(self) -> Array:
        """(n, 3) of the reference point O [m]"""
        return _masked(*self._arrays.displacement)

    @property
    def rotation(self) -> Array:
        """(n, 3) rotation vector of the end-effector [rad]"""
        return _masked(*self._arrays.rotation)

    @property
    def compliance(self) -> Array:
        """(n, 6, 6) at O, drive free: [m m m rad rad rad] against [N N N N m N m N m]"""
        return _masked(*self._arrays.compliance_free)

    @property
    def compliance_locked(self) -> Array:
        """(n, 6, 6) the same with the drive held"""
        return _masked(*self._arrays.compliance_locked)

    @property
    def frequencies(self) -> Array:
        """(n, m) natural frequencies, drive free, ascending [Hz]"""
        return _masked(*self._arrays.frequencies_free)

    @property
    def frequencies_locked(self) -> Array:
        """(n, m) the same with the drive held [Hz]"""
        return _masked(*self._arrays.frequencies_locked)

    def gradient(self, quantity: str) -> Array:
        """(n, p) exact derivatives by ``parameters``, SI per SI; formulas among them follow."""
        if not self._arrays.has_gradients:
            raise NoGradient("there are none: evaluate(..., gradients=True) has them")
        return _masked(*self._arrays.gradient(quantity))

    @property
    def gradients(self) -> Gradients:
        """``gradients[quantity][parameter]``: (n,)"""
        return Gradients(self)

    def to_pandas(self) -> Any:
        """A ``pandas.DataFrame``: a row for each stroke point, a column for each quantity."""
        pandas = importlib.import_module("pandas")
        columns = {f"stroke.{name}": values for name, values in self.strokes.items()}
        columns |= {name: _ma.filled(self[name], np.nan) for name in self.names}
        return pandas.DataFrame(columns, index=pandas.Index(self.stroke, name="stroke"))

    def to_xarray(self) -> Any:
        """An ``xarray.Dataset``: quantities, compliance and frequencies along ``stroke``, with their units."""
        xarray = importlib.import_module("xarray")
        def of(dims: tuple[str, ...], values: Array, unit: str) -> Any:
            return (dims, _ma.filled(values, np.nan), {"units": unit})

        units = self.units
        data = {name: of(("stroke",), self[name], units[name]) for name in self.names}
        data["compliance"] = of(("stroke", "motion", "load"), self.compliance, "SI")
        data["compliance_locked"] = of(("stroke", "motion", "load"), self.compliance_locked, "SI")
        data["frequencies"] = of(("stroke", "mode"), self.frequencies, "Hz")
        data["frequencies_locked"] = of(("stroke", "mode"), self.frequencies_locked, "Hz")
        six = ["ux", "uy", "uz", "rx", "ry", "rz"]
        coordinates = {"stroke": self.stroke, "motion": six, "load": six}
        coordinates |= {f"stroke.{name}": ("stroke", s) for name, s in self.strokes.items()}
        return xarray.Dataset(data, coordinates)


class Result:
    """Of every kind of run."""

    def __init__(self, run: _core.Run, status: str, folder: str) -> None:
        self._run = run
        self._status = status
        #: Where its files are; empty: none were written.
        self.folder = folder

    @property
    def status(self) -> str:
        """``ok``, or why the result is not usable."""
        return self._status

    @property
    def message(self) -> str:
        """One sentence with the figures."""
        return self._run.message

    @property
    def seconds(self) -> float:
        """What the computation took [s]; files aside."""
        return self._run.seconds

    @property
    def failed_expectations(self) -> list[str]:
        """Of a run with a folder: what the job's ``expect`` says otherwise."""
        return self._run.failed_expectations

    def to_dict(self) -> dict[str, Any]:
        """The content of result.json."""
        return self._content

    @functools.cached_property
    def _content(self) -> dict[str, Any]:
        return self._run.result()

    def to_html(self) -> str:
        """The report: one page that needs nothing else."""
        return self._run.report()

    def _repr_html_(self) -> str:
        page = html.escape(self.to_html(), quote=True)
        return (
            f"<p>{html.escape(self.message)}</p>"
            f'<iframe srcdoc="{page}" width="100%" height="720" style="border:0"></iframe>'
        )

    def __repr__(self) -> str:
        return f"<flexopt.{type(self).__name__} {self.status}: {self.message}>"


class Evaluation(Result, Path):
    """One design over its stroke: what ``Path`` has, of several load cases that of the first."""

    def __init__(
        self, run: _core.Run, status: str, folder: str, parameters: list[str]
    ) -> None:
        Result.__init__(self, run, status, folder)  # and not Path's: all calls wait for it
        self.parameters = parameters

    @functools.cached_property
    def cases(self) -> dict[str, Path]:
        """Of several load cases their paths by name."""
        names = self._run.case_names
        return {name: Path(self._run, k, self.parameters) for k, name in enumerate(names)}

    def state_space(self, point: int, case: str | None = None) -> StateSpace:
        """The linear model about a point of the path; the job must export it.

        ``case``: of several load cases another one than the first. ``KeyError`` where the point has
        no model.
        """
        result = self.to_dict()
        path = result["path"] if case is None else result["cases"][case]["path"]
        model = path[point].get("state_space")
        if model is None:
            raise KeyError(f"point {point} has no linear model")
        omega2, damping = np.array(model["omega2"]), np.array(model["damping"])
        forces, motions = np.array(model["forces"]), np.array(model["motions"])
        n = len(omega2)
        damped = np.diag(2 * damping * np.sqrt(np.abs(omega2)))
        signals = result["state_space"]
        return StateSpace(
            np.block([[np.zeros((n, n)), np.eye(n)], [-np.diag(omega2), -damped]]),
            np.vstack([np.zeros_like(forces), forces]),
            np.hstack([motions, np.zeros_like(motions)]),
            np.array(model["residual"]),
            [signal["name"] for signal in signals["inputs"]],
            [signal["name"] for signal in signals["outputs"]],
        )


class Optimum(Evaluation):
    """The design that an optimisation found; its path is that of the optimum."""

    def __init__(self, run: _core.Run, status: str, folder: str) -> None:
        Evaluation.__init__(self, run, status, folder, [])

    @property
    def details(self) -> dict[str, Any]:
        """The part ``optimum`` of result.json."""
        return cast("dict[str, Any]", self.to_dict()["optimum"])

    @property
    def objective(self) -> float | None:
        """SI; None where no design could be evaluated."""
        return cast("float | None", self.details["objective"])

    @property
    def design(self) -> dict[str, float]:
        """Every parameter of the optimum, SI."""
        return cast("dict[str, float]", self.details["parameters"])

    @property
    def constraints(self) -> list[dict[str, Any]]:
        """Each with label, value, bounds and margin."""
        return cast("list[dict[str, Any]]", self.details["constraints"])


class Comparison(Result):
    """Models compared with full accuracy over sampled designs."""

    @property
    def details(self) -> dict[str, Any]:
        """The part ``comparison`` of result.json."""
        return cast("dict[str, Any]", self.to_dict()["comparison"])
