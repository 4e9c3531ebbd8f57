"""Jobs from files, dicts and designs."""

from __future__ import annotations

import json
import os
from typing import Any, Mapping, Union

from . import _core


def _of_design(source: Mapping[str, Any]) -> bool:
    """Whether it is a design, not a job."""
    return isinstance(source, Design) or (
        "design" not in source and not {"family", "file", "mechanism"}.isdisjoint(source)
    )


def _plain(value: Any) -> Any:
    """For JSON: what numpy's arrays and numbers, and paths, are in Python's own types."""
    return value.tolist() if hasattr(value, "tolist") else os.fspath(value)


class Job:
    """A job that was read and checked: worth keeping where it is run often.

    ``source``: a file name or a dict, the same JSON as the file's; or a design, to be evaluated.
    ``keys`` take the places of the job's own at the top: ``Job("guide.json", frequencies=8)``.
    Raises ``JobError``.
    """

    def __init__(self, source: str | os.PathLike[str] | Mapping[str, Any], **keys: Any) -> None:
        if isinstance(source, Mapping):
            if _of_design(source):
                source = {"flexopt": 1, "name": "design", "job": "evaluate", "design": {**source}}
            self._core = _core.Job.parse({**source, **keys})
        else:
            overrides = [f"/{key}={json.dumps(value, default=_plain)}" for key, value in keys.items()]
            self._core = _core.Job.read(os.fspath(source), overrides)
        self._of_kind: dict[str, _core.Job] = {}

    def _as(self, kind: str) -> _core.Job:
        job = self._of_kind.get(kind)
        if job is None:
            job = self._of_kind[kind] = self._core.as_kind(kind)
        return job

    @property
    def name(self) -> str:
        return self._core.name

    @property
    def kind(self) -> str:
        """``evaluate``, ``optimise`` or ``compare``."""
        return self._core.kind

    @property
    def parameters(self) -> dict[str, float]:
        """Of its design, SI."""
        return self._core.parameters

    @property
    def differentiable(self) -> list[str]:
        """Names that results can be differentiated by."""
        return self._core.differentiable

    @property
    def notes(self) -> list[str]:
        """What is odd but allowed."""
        return self._core.notes

    def to_dict(self) -> dict[str, Any]:
        """The job with defaults filled in, SI."""
        return self._core.document()

    def __repr__(self) -> str:
        return f"<flexopt.Job {self.kind}: {self.name}>"


class Design(dict[str, Any]):
    """The part ``design`` of a job: a dict that ``evaluate`` takes too."""


def _is_file(source: str) -> bool:
    """Whether the name is one of a file; families have no dots and no folders."""
    if source in _core.family_names():
        return False
    return os.path.exists(source) or "." in source or os.path.basename(source) != source


def design(source: str | os.PathLike[str] | Mapping[str, Any], **parameters: Any) -> Design:
    """A mechanism: the name of a family, a design file, or a design (or a job's) as a dict.

    ``parameters``: numbers in SI units or texts with a unit, ``"0.5 mm"``; ``material`` is the name
    of one or a dict, and the family's options go here too. Raises ``JobError`` for a name that the
    mechanism does not have; values are checked when the design is evaluated.
    """
    if isinstance(source, Mapping):
        made = Design(source)
        if "flexopt_design" in source:  # a design file's content
            made = Design(mechanism=dict(source))
    elif _is_file(os.fspath(source)):
        made = Design(file=os.path.abspath(source))
    else:
        made = Design(family=os.fspath(source))
    options = _core.option_names(made["family"]) if "family" in made else []
    made["parameters"] = dict(made.get("parameters", {}))
    for name, value in parameters.items():
        (made if name in ("material", *options) else made["parameters"])[name] = value
    if not {"family", "file", "mechanism"}.isdisjoint(made):
        _core.check_names(made)
    return made


Source = Union[Job, Design, Mapping[str, Any], str, "os.PathLike[str]"]


def as_job(source: Source, keys: Mapping[str, Any], kind: str) -> _core.Job:
    """A checked job of this kind."""
    if isinstance(source, Job):
        if keys:
            raise TypeError(f"{', '.join(keys)}: a Job is as it is; give these to Job(...)")
        return source._as(kind)
    if isinstance(source, Mapping) and _of_design(source):
        keys = {"job": kind, **keys}
    return Job(source, **keys)._as(kind)
