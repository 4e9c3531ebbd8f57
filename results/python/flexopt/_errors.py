"""What goes wrong: wrong input, and numbers that do not work out."""

from __future__ import annotations

from dataclasses import astuple, dataclass
from typing import TYPE_CHECKING, Any, Iterable

if TYPE_CHECKING:
    from ._results import Evaluation


@dataclass(frozen=True)
class Fault:
    """One thing that is wrong with the input."""

    pointer: str  #: JSON pointer into the job
    value: str  #: what stands there
    rule: str  #: what would be right
    source: str = ""  #: file that it stands in; empty: none
    line: int = 0  #: in the file, from 1; 0: unknown
    column: int = 0


class JobError(ValueError):
    """The input is wrong; ``faults`` has every place, the other attributes are of the first one."""

    def __init__(
        self, message: str, faults: Iterable[tuple[str, str, str, str, int, int]]
    ) -> None:
        super().__init__(message)
        self.faults = [Fault(*fault) for fault in faults]
        first = self.faults[0]
        self.pointer, self.value, self.rule = first.pointer, first.value, first.rule

    def __reduce__(self) -> tuple[Any, ...]:  # between processes
        return type(self), (self.args[0], [astuple(fault) for fault in self.faults])


class NotConverged(ArithmeticError):
    """No values at a design. An optimiser does best to try one that is nearer to the last good one.

    ``stroke`` [m or rad]: how far the path came; None where it did not begin, as of a design whose
    parameters make no geometry. ``result``: of ``evaluate``, all that there is; None in another
    process.
    """

    def __init__(
        self, message: str, stroke: float | None = None, result: Evaluation | None = None
    ) -> None:
        super().__init__(message)
        self.stroke = stroke
        self.result = result

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.args[0], self.stroke)


class NoGradient(ValueError):
    """Exact derivatives were asked for, and the model has none; the message says why."""
