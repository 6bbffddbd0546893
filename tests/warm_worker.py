"""The test processes of pytest-xdist as forks of one that has collected the tests.

Collecting takes longer than anything else that every test process does: it imports all test modules and makes
each test. `collect` does it once, in the interpreter that `warm_start` forks; `work` does the rest of what
`xdist.remote`, the module that this one stands for, does in a test process.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import execnet
    import pytest

# What the tests are given on the command line, for the interpreter that collects them.
_ARGUMENTS = "COLLECTED_TESTS"


# Libraries start no threads with these: numpy's, and the allocator of pyarrow.
_WITHOUT_THREADS = {"OPENBLAS_NUM_THREADS": "1", "JE_ARROW_MALLOC_CONF": "background_thread:false"}


def variables(config: pytest.Config) -> dict[str, str]:
    """Return what the interpreter that collects has in its environment."""
    arguments = json.dumps([str(word) for word in config.invocation_params.args])
    return {_ARGUMENTS: arguments, **_WITHOUT_THREADS}


class Collected:
    """A session with its tests, which no test has run in."""

    def __init__(self, arguments: list[str]) -> None:
        """Collect the tests; exits where it cannot, for an ordinary start reports what is wrong."""
        from _pytest.config import _prepareconfig

        # The terminal's reporter, which every test process has, goes on writing here.
        sys.stdout = Path(os.devnull).open("w")  # noqa: SIM115 - kept by the reporter
        self.config = _prepareconfig(arguments, None)
        # Rewrites the asserts of plugins, so xdist is imported after it.
        from xdist.remote import setup_config  # type: ignore[import-untyped]

        setup_config(self.config, None)
        # Plugins tell by it that this is a test process.
        self.config.workerinput = {}  # type: ignore[attr-defined]
        self.skipped: list[pytest.CollectReport] = []
        self.config.pluginmanager.register(self)
        self.session = self._collected_session()
        # A fork does not have the threads of a library, which waits for them when it forks in turn.
        has_threads = len(list(Path("/proc/self/task").iterdir())) > 1
        if self.session.testsfailed or self.session.shouldstop or has_threads:
            os._exit(1)
        self._captures = self.config.pluginmanager.getplugin("capturemanager")
        self._captures.stop_global_capturing()
        self._path = list(sys.path)

    def _collected_session(self) -> pytest.Session:
        import pytest

        session = pytest.Session.from_config(self.config)
        self.config._do_configure()
        self.config.hook.pytest_sessionstart(session=session)
        self.config.hook.pytest_collection(session=session)
        return session

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        """Keep what was skipped, for each test process reports it."""
        if not report.passed:
            self.skipped.append(report)

    def work(self, channel: execnet.Channel) -> None:
        """Run tests for the controller at the other end of a channel, in a fork."""
        import pytest
        import xdist.remote  # type: ignore[import-untyped]
        from _pytest.tmpdir import TempPathFactory

        import children

        workerinput, _, options, _ = channel.receive()
        sys.path[:] = self._path
        os.environ["PYTEST_XDIST_TESTRUNUID"] = workerinput["testrunuid"]
        os.environ["PYTEST_XDIST_WORKER"] = workerinput["workerid"]
        os.environ["PYTEST_XDIST_WORKER_COUNT"] = str(workerinput["workercount"])
        config, session = self.config, self.session
        config.pluginmanager.unregister(self)
        config.option.basetemp = options.get("basetemp")
        config._tmp_path_factory = TempPathFactory.from_config(config, _ispytest=True)  # type: ignore[attr-defined]
        config.workerinput, config.workeroutput = workerinput, {}  # type: ignore[attr-defined]
        children.pytest_configure()
        self._captures.start_global_capturing()
        self._captures.suspend_global_capture()

        worker = xdist.remote.WorkerInteractor(config, channel)
        # Its hook for internal errors looks for this name.
        xdist.remote.interactor = worker
        worker.pytest_sessionstart(session)
        worker.pytest_collection()
        for report in self.skipped:
            worker.pytest_collectreport(report)
        worker.pytest_collection_finish(session)
        # What else is raised reaches the controller through the channel.
        status = pytest.ExitCode.INTERNAL_ERROR
        try:
            config.hook.pytest_runtestloop(session=session)
            status = pytest.ExitCode.TESTS_FAILED if session.testsfailed else pytest.ExitCode.OK
        except (KeyboardInterrupt, pytest.exit.Exception):
            status = pytest.ExitCode.INTERRUPTED
            config.hook.pytest_keyboard_interrupt(excinfo=pytest.ExceptionInfo.from_current())
        finally:
            config.hook.pytest_sessionfinish(session=session, exitstatus=status)
            config._ensure_unconfigure()


if __name__ == "__channelexec__":
    sys.modules["warm_worker"].COLLECTED.work(channel)  # type: ignore[name-defined]  # noqa: F821 - execnet defines it
elif _ARGUMENTS in os.environ:
    COLLECTED = Collected(json.loads(os.environ.pop(_ARGUMENTS)))
