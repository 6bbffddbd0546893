from __future__ import annotations

import pytest

from rostether.cli.access.ros2_tool_node import warn_without_router
from rostether.errors import GraphError
from rostether.ros2.zenoh import configuration


@pytest.mark.parametrize("is_error", [False, True])
async def test_a_missing_router_is_an_error_for_lists(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], is_error: bool
) -> None:
    async def no_router() -> bool:
        return False

    monkeypatch.setattr(configuration, "is_router_there", no_router)
    monkeypatch.setattr(configuration, "configures_endpoints", lambda _: False)
    if is_error:
        with pytest.raises(GraphError, match="no zenoh router answers"):
            await warn_without_router(is_error=True)
    else:
        await warn_without_router()
        assert "no zenoh router answers" in capsys.readouterr().err
