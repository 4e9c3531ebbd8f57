"""The goals of a job as functions, for optimisers of others."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._jobs import Source, as_job

Array = NDArray[np.float64]


class Problem:
    """min f(x) subject to g_lower <= g(x) <= g_upper and x within its bounds.

    ``job``: with a part ``optimise``; its algorithm and starts do not matter here.

    ``scaled``: x in [0, 1] between the bounds of the job, f and g divided by what makes them of
    order one; else all is SI. ``pointwise``: a bound over the stroke becomes one on each point, and
    a worst value over the stroke as the objective becomes a further variable ``t``, the last of x,
    with constraints of its own: more rows, all of them smooth.

    Every method raises ``NotConverged`` where the design has no values, ``df`` and ``dg``
    ``NoGradient`` where it has no derivatives. Designs are remembered: once df or dg was asked for,
    f, g, df and dg at one x cost one evaluation with derivatives. An x out of its bounds is taken as
    it is.
    """

    def __init__(
        self, job: Source, *, scaled: bool = True, pointwise: bool = False, **keys: Any
    ) -> None:
        self._core = _core.PosedGoals(as_job(job, keys, "optimise"), scaled, pointwise)
        #: Of the variables.
        self.names: list[str] = self._core.names
        #: (n,) where to begin
        self.x0: Array = self._core.start
        #: (n,) each
        self.lower: Array = self._core.lower
        self.upper: Array = self._core.upper
        #: Of the rows of g; pointwise with the stroke point, and the mode or place of stress there.
        self.g_names: list[str] = self._core.constraint_names
        #: (m,) each
        self.g_lower: Array = self._core.constraint_lower
        self.g_upper: Array = self._core.constraint_upper

    @property
    def bounds(self) -> list[tuple[float, float]]:
        """n pairs, as scipy takes them."""
        return [(float(a), float(b)) for a, b in zip(self.lower, self.upper)]

    def f(self, x: ArrayLike) -> float:
        """What is to be minimised: the objective, with its sign turned where it is maximised."""
        return self._core.f(np.asarray(x, float))

    def g(self, x: ArrayLike) -> Array:
        """(m,)"""
        return self._core.g(np.asarray(x, float))

    def df(self, x: ArrayLike) -> Array:
        """(n,) exact"""
        return self._core.df(np.asarray(x, float))

    def dg(self, x: ArrayLike) -> Array:
        """(m, n) exact"""
        return self._core.dg(np.asarray(x, float))

    def jac(self, x: ArrayLike) -> tuple[Array, Array]:
        """(n,) and (m, n): of f and of g"""
        return self.df(x), self.dg(x)

    def objective(self, x: ArrayLike) -> float:
        """As the job has it, SI."""
        return self._core.objective(np.asarray(x, float))

    def parameters(self, x: ArrayLike) -> dict[str, float]:
        """Every parameter of the design at x, SI."""
        return self._core.parameters(np.asarray(x, float))
