"""The node in programs with asyncio."""

from asyncio import sleep

from ros.ticks import ticks_diff, ticks_ms


async def spin(node_handle, pause_s=0.002):
    """Spin forever while other tasks run. `pause_s` is the time between calls of spinOnce."""
    while True:
        node_handle.spinOnce()
        await sleep(pause_s)


async def call(client, request, timeout_ms=10000):
    """Call a service while `spin` runs as another task; return and raise the same as ServiceClient.call."""
    if not client.begin(request):
        return None
    began_ms = ticks_ms()
    try:
        while client.is_waiting() and ticks_diff(ticks_ms(), began_ms) < timeout_ms:
            await sleep(0.002)
    finally:
        response = client.end()
    return response
