"""Clients under test in memory: the conformance program on a Python Device, with faults in its bytes."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager

from rostether.conformance.case import Case, Outcome
from rostether.conformance.checked_client import CheckedClient
from rostether.conformance.program import ConformanceProgram
from rostether.conformance.run_cases import CASES, run_cases
from rostether.device.device import Device
from rostether.msgdef.registry import Registry
from rostether.rosserial.device_link import DeviceLinkConfig
from rostether.serde.store import TypeStore
from rostether.transports.memory import Manipulator, MemoryTransport, memory_pair

STORE = TypeStore(Registry())
# The buffer size of a board, so that short messages reach the limits.
CONFIG = DeviceLinkConfig(input_buffer_bytes=280, output_buffer_bytes=300)


@asynccontextmanager
async def a_client(plant: Callable[[], Manipulator] | None = None) -> AsyncIterator[CheckedClient]:
    """Yield a client to check; each connection starts the program and its fault again, like a reset."""
    devices: list[Device] = []

    async def connect() -> MemoryTransport:
        for each in devices:
            await each.close()
        near, far = memory_pair(plant and plant())
        device = Device(far, store=STORE, config=CONFIG)
        ConformanceProgram(device)
        await device.__aenter__()
        devices[:] = [device]
        return near

    client = CheckedClient(connect)
    try:
        yield client
    finally:
        await client.close()
        for each in devices:
            await each.close()


async def outcomes(
    plant: Callable[[], Manipulator] | None = None, cases: Sequence[Case] = CASES
) -> list[Outcome]:
    """Run the cases against a client."""
    async with a_client(plant) as client:
        await client.open()
        return [each async for each in run_cases(client, cases)]
