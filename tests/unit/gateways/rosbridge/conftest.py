"""A rosbridge server with clients, as a fixture."""

from __future__ import annotations

from collections.abc import AsyncIterator

import pytest

from unit.gateways.rosbridge.web_client import World, world


@pytest.fixture
async def there() -> AsyncIterator[World]:
    async with world() as made:
        yield made
