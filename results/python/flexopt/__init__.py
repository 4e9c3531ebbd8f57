"""flexopt evaluates and optimises flexure mechanisms: leaf-spring guides and hinges that bend far.

    import flexopt
    hinge = flexopt.design("cross_hinge", length="60 mm", width="20 mm", thickness="0.3 mm", ...)
    r = flexopt.evaluate(hinge, stroke={"from": 0, "to": "20 deg", "points": 11}, gradients=True)
    r["support_stiffness.uy"], r.gradients["drive_load"]["thickness"]

Numbers are in SI units and radians.
"""

from __future__ import annotations

import os
from typing import Any, Callable, Iterable

from . import _core
from ._errors import Fault, JobError, NoGradient, NotConverged
from ._jobs import Design, Job, Source, as_job, design
from ._problem import Problem
from ._results import Comparison, Evaluation, Gradients, Optimum, Path, Result, StateSpace

__version__ = _core.version

#: Told how far a run is: (done, total, text), and (0, 0, text) of what begins. From any thread, one
#: call at a time; an exception ends the run and comes out of it.
Progress = Callable[[int, int, str], object]

__all__ = [
    "Comparison",
    "Design",
    "Evaluation",
    "Fault",
    "Gradients",
    "Job",
    "JobError",
    "NoGradient",
    "NotConverged",
    "Optimum",
    "Path",
    "Problem",
    "Progress",
    "Result",
    "StateSpace",
    "compare",
    "design",
    "evaluate",
    "optimise",
]


def _folder(out: str | os.PathLike[str] | None) -> str:
    return "" if out is None else os.fsdecode(out)


def _along(gradients: bool | str | Iterable[str] | None, job: _core.Job) -> list[str]:
    """Names of what derivatives are by."""
    if isinstance(gradients, str):
        return [gradients]
    if isinstance(gradients, Iterable):
        return list(gradients)
    return job.differentiable if gradients else []


def evaluate(
    job: Source,
    *,
    gradients: bool | str | Iterable[str] | None = False,
    out: str | os.PathLike[str] | None = None,
    threads: int = 0,
    progress: Progress | None = None,
    **keys: Any,
) -> Evaluation:
    """A design over its stroke: of a job (whatever its kind, its own design), or of a ``design``.

    ``gradients``: exact derivatives too, by all parameters of the design, its material and its
    end-effector, or by those named. They are those of full leaves, or of looked-up ones: all numbers
    are then by these, and the message says so. ``out``: folder for the files of a run; None: nothing is
    written. ``threads``: 0 for all of the processor; no number depends on it. ``keys``: other parts
    of the job: ``stroke``, ``end_effector``, ``frequencies`` and so on.

    Raises ``JobError``, ``NotConverged`` (with the result as far as it goes), ``NoGradient``.
    """
    checked = as_job(job, keys, "evaluate")
    along = [] if gradients is False else _along(gradients, checked)
    folder = _folder(out)
    run, status = _core.run(checked, along, folder, threads, progress)
    if along and status == "ok" and run.no_gradients:
        raise NoGradient(run.no_gradients)
    result = Evaluation(run, status, folder, along)
    if status in ("no_equilibrium", "left_branch", "limit_reached"):
        paths: list[Path] = [*result.cases.values()] or [result]
        reached = [path.stroke_reached for path in paths if path.status != "ok"]
        raise NotConverged(run.message, reached[0], result)
    return result


def optimise(
    job: Source,
    progress: Progress | None = None,
    *,
    out: str | os.PathLike[str] | None = None,
    threads: int = 0,
    **keys: Any,
) -> Optimum:
    """Looks for the best design of a job with a part ``optimise``; arguments as of ``evaluate``.

    With ``out`` an interrupted run goes on where it stopped when it is called again. ``status``
    tells an optimum (``ok``) from a search that did not end, and from one without a feasible design.
    """
    run, status = _core.run(as_job(job, keys, "optimise"), [], _folder(out), threads, progress)
    return Optimum(run, status, _folder(out))


def compare(
    job: Source,
    progress: Progress | None = None,
    *,
    out: str | os.PathLike[str] | None = None,
    threads: int = 0,
    **keys: Any,
) -> Comparison:
    """Models against full accuracy over sampled designs; arguments as of ``optimise``."""
    run, status = _core.run(as_job(job, keys, "compare"), [], _folder(out), threads, progress)
    return Comparison(run, status, _folder(out))
