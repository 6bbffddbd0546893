"""The parts that the dashboard's gateway adds to Foxglove's protocol."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from msgspec import Struct

from rostether.gateways.foxglove.recordings import RecordingControl
from rostether.gateways.websocket.access_rules import Rights
from rostether.gateways.websocket.site import Site
from rostether.graph.ports import Graph
from rostether.transports.web_boards import WebBoards


class DashboardParts(Struct, frozen=True):
    """The optional parts of a gateway.

    `site` has the files to serve. `join_teleop` makes the node of clients that drive. `recordings` records
    for clients. `boards` are boards on serial ports of the devices that show the page.
    """

    site: Site | None = None
    join_teleop: Callable[[], Awaitable[Graph]] | None = None
    recordings: RecordingControl | None = None
    boards: WebBoards | None = None

    def metadata(self, rights: Rights) -> dict[str, str]:
        """Return the metadata about the parts for a client with `rights`."""
        features = ["drive"] if self.join_teleop is not None and rights is Rights.FULL else []
        if self.recordings is not None:
            features.append("record")
        if self.boards is not None and rights is Rights.FULL:
            features.append("serial")
        return {"rights": rights.value, "features": ",".join(features)}
