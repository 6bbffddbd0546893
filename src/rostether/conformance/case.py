"""A case: one requirement of the protocol, the endpoints that it needs, and how to check it."""

from __future__ import annotations

import inspect
from collections.abc import Awaitable, Callable
from enum import StrEnum
from typing import TypeAlias

from msgspec import Struct

from rostether.conformance.checked_client import CheckedClient
from rostether.conformance.program import Part

Check: TypeAlias = Callable[[CheckedClient], Awaitable[None]]


class Verdict(StrEnum):
    """The outcome of one case."""

    PASS = "pass"  # noqa: S105 - not a password
    FAIL = "fail"
    NOT_APPLICABLE = "not applicable"


class Case(Struct, frozen=True):
    """One requirement; `name` is its stable key, `requirement` a sentence, `wait_s` its waiting time."""

    name: str
    requirement: str
    check: Check
    needs: tuple[Part, ...] = ()
    wait_s: float = 0.0


class Outcome(Struct, frozen=True):
    """The verdict on a case; `seen` is the deviation, or why the case was not applicable."""

    case: Case
    verdict: Verdict
    seen: str = ""


class CaseList:
    """Collects the cases of a module in source order."""

    def __init__(self) -> None:
        self.cases: list[Case] = []

    def __call__(self, name: str, *needs: Part, wait_s: float = 0.0) -> Callable[[Check], Check]:
        """Add the decorated function as a case; its docstring is the requirement."""

        def add(check: Check) -> Check:
            self.cases.append(Case(name, inspect.getdoc(check) or name, check, needs, wait_s))
            return check

        return add
