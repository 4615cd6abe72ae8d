"""What a table or figure of the paper consists of: pieces of work, then lines of numbers.

A file of this folder that tells one item has

    TITLE                     what it is, as a heading
    jobs(scale)               the pieces of work whose answers it needs, each plain JSON
    findings(scale, answers)  its numbers beside the paper's, its figures and what there is to say

Pieces of work run in any order and in several processes; their answers are kept in files, so that
a run that was killed goes on where it was.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol, TypeVar, runtime_checkable

from matplotlib.figure import Figure

from rotorpong.lab.spec import Spec

Value = float | int | None
Answers = Mapping[str, Any]
"""What the jobs of an item returned, by their keys."""

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Scale:
    """How much is played."""

    seed: int = 0
    quick: bool = False  # rough numbers within a minute and a half, all items together

    def of(self, whole: T, quick: T) -> T:
        """Return what holds for this scale."""
        return quick if self.quick else whole


@dataclass(frozen=True, slots=True)
class Training:
    """A training run; jobs, also those of several items, share it if they ask for the same."""

    spec: Spec
    hits: int  # own hits; 20 balls for each are thrown at most


@dataclass(frozen=True, slots=True)
class Job:
    """A piece of work: `function(*arguments, *experience files)`, of a module, returning JSON."""

    key: str
    function: Callable[..., Any]
    arguments: tuple[Any, ...] = ()
    trainings: tuple[Training, ...] = ()
    seconds: float = 1.0  # about; longer ones begin first


@dataclass(frozen=True, slots=True)
class Column:
    """One quantity of a table."""

    key: str  # in the JSON, with the unit: "x_cm"
    head: str  # on the page: "X, cm"
    digits: int = 2  # after the point, on the page


@dataclass(frozen=True, slots=True)
class Line:
    """One line of a table: the paper's, or one of ours.

    `values` has the columns' keys, None for what is not known; `KEY_sd` and `KEY_interval`, a
    standard deviation and a 95 % interval, are printed beside KEY. Other keys are in the JSON only.
    """

    label: str
    values: Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Findings:
    """What came out of an item."""

    columns: Sequence[Column]
    paper: Sequence[Line]
    ours: Sequence[Line]
    setting: Mapping[str, Any]  # what was played, in JSON
    figures: Mapping[str, "Figure | bytes"] = field(default_factory=dict)  # by name; bytes: a PNG
    remarks: str = ""  # Markdown, below the table: what differs, and why


@runtime_checkable
class Item(Protocol):
    """A file of this folder that tells one table or figure."""

    TITLE: str

    def jobs(self, scale: Scale) -> Sequence[Job]:
        """Return the pieces of work."""
        ...

    def findings(self, scale: Scale, answers: Answers) -> Findings:
        """Return what came out of them."""
        ...
