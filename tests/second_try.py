"""A second try for a test that failed while other tests ran, with new fixtures, reported at the end of the
run.

The test processes keep the machine busy, so boards and peers in real time may be late. A test that is run
alone has one try.
"""

from __future__ import annotations

import os
from typing import Any

import pytest
from _pytest.runner import runtestprotocol

# The attribute of a report with the failure of the first try. pytest-xdist sends it to the controller.
_FIRST_FAILURE = "first_failure"
# A shorter step of a fixture is not among the slowest, which pytest lists on request.
_LONG_S = 0.1
_MAX_FAILURE_CHARS = 600
_MAX_OUTPUT_CHARS = 10_000

_failures: list[tuple[str, str]] = []


def pytest_runtest_protocol(item: pytest.Item, nextitem: pytest.Item | None) -> bool | None:
    """Run a test in a test process of pytest-xdist; if it fails, run it again."""
    if "PYTEST_XDIST_WORKER" not in os.environ:
        return None
    if item.config.get_verbosity() > 0:
        # Only -v shows it; a message to the controller costs as much as a short test.
        item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
    reports = runtestprotocol(item, nextitem=nextitem, log=False)
    failed = [each for each in reports if each.failed]
    if failed:
        # The module's fixtures are also created again, because they may have the fault. Their errors do not
        # matter.
        module = item.getparent(pytest.Module)
        folder = module and module.parent
        state: Any = item.session._setupstate
        pytest.CallInfo.from_call(lambda: state.teardown_exact(folder), "teardown")
        item._initrequest()  # type: ignore[attr-defined]
        reports = runtestprotocol(item, nextitem=nextitem, log=False)
        setattr(reports[-1], _FIRST_FAILURE, _summary(failed[0]))
    for report in filter(_must_be_sent, reports):
        item.ihook.pytest_runtest_logreport(report=report)
    item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
    return True


def _must_be_sent(report: pytest.TestReport) -> bool:
    """Return whether a report must go to the controller: reports of fixtures cost as much as those of
    tests.
    """
    is_slow = report.duration > _LONG_S
    return report.when == "call" or not report.passed or is_slow or hasattr(report, _FIRST_FAILURE)


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Keep the first failures for the end of the run."""
    if failure := getattr(report, _FIRST_FAILURE, ""):
        _failures.append((report.nodeid, failure))


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """List the tests that had a second try, with the failure of the first."""
    if not _failures:
        return
    terminalreporter.section("second tries")
    for test, failure in _failures:
        terminalreporter.write_line(f"{test}: {failure}")


def _summary(report: pytest.TestReport) -> str:
    text = report.longreprtext
    # pytest begins the lines of an error's message with this letter; groups of errors have none.
    message = [line[1:] for line in text.splitlines() if line.startswith("E ")] or [
        text[-_MAX_FAILURE_CHARS:]
    ]
    crash = getattr(report.longrepr, "reprcrash", None)
    position = "" if crash is None else f"{crash.path}:{crash.lineno}: "
    output = "".join(f"\n--- {title}:\n{lines}" for title, lines in report.sections)
    return position + " ".join(" ".join(message).split())[:_MAX_FAILURE_CHARS] + output[:_MAX_OUTPUT_CHARS]
