"""Runs the test processes of pytest-xdist as forks of a process that has collected the tests.

Collecting takes longer than anything else that every test process does: it imports all test modules and makes
each test. `collect` does it once, in the interpreter that `warm_start` forks; `work` does the rest of what
`xdist.remote`, the module that this one replaces, does in a test process.
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

# The arguments of the command line, for the interpreter that collects the tests.
_ARGUMENTS = "COLLECTED_TESTS"


# With these, numpy's libraries and pyarrow's allocator start no threads.
_WITHOUT_THREADS = {"OPENBLAS_NUM_THREADS": "1", "JE_ARROW_MALLOC_CONF": "background_thread:false"}


def variables(config: pytest.Config) -> dict[str, str]:
    """Return the environment variables of the interpreter that collects."""
    arguments = json.dumps([str(argument) for argument in config.invocation_params.args])
    return {_ARGUMENTS: arguments, **_WITHOUT_THREADS}


class Collected:
    """A session with collected tests, none of which has run."""

    def __init__(self, arguments: list[str]) -> None:
        """Collect the tests; exit if that fails, because a normal start reports the reason."""
        from _pytest.config import _prepareconfig

        # The reporter of the terminal continues to write here in every test process.
        sys.stdout = Path(os.devnull).open("w")  # noqa: SIM115 - kept by the reporter
        self.config = _prepareconfig(arguments, None)
        # Rewrites the asserts of plugins, so xdist is imported after it.
        from xdist.remote import setup_config  # type: ignore[import-untyped]

        setup_config(self.config, None)
        # Plugins recognize a test process by this.
        self.config.workerinput = {}  # type: ignore[attr-defined]
        self.skipped: list[pytest.CollectReport] = []
        self.config.pluginmanager.register(self)
        self.session = self._collected_session()
        # A fork lacks the threads of a library, which waits for them at the next fork.
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
        """Keep the skipped modules, because each test process reports them."""
        if not report.passed:
            self.skipped.append(report)

    def work(self, channel: execnet.Channel) -> None:
        """Run tests for the controller at the other end of a channel. Runs in a fork."""
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
        # xdist's hook for internal errors uses this name.
        xdist.remote.interactor = worker
        worker.pytest_sessionstart(session)
        worker.pytest_collection()
        for report in self.skipped:
            worker.pytest_collectreport(report)
        worker.pytest_collection_finish(session)
        # Other exceptions reach the controller through the channel.
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
