"""Diagnoses one link: checks and opens the port, bridges the board into a private graph, reports findings.

    port facts ── bad ──> findings
        │
      open ── failed ──> finding
        │
      listen and ask ── frames ──> watch for a while ──> findings, or no problem found
        │
      none, on a real port: try the usual baud rates ── found ──> finding, and watch at that rate

It uses the session and the findings of the bridge; only the graph is a private one, in memory.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from functools import partial
from typing import cast

from msgspec import Struct
from msgspec.structs import replace

from rostether.bridge.findings.finding import Code, Finding, error
from rostether.bridge.findings.line_watch import NO_ANSWER_S
from rostether.bridge.findings.noise import show
from rostether.bridge.findings.port import busy, cannot_open, open_error_finding, port_finding
from rostether.bridge.health.watching import WATCH_S, BoardObservations, watch_board
from rostether.bridge.peer_entry import BOARD_ENTRY
from rostether.bridge.ports.port_probe import TunableTransport, probe_port
from rostether.errors import RostetherError, TransportError
from rostether.mechanisms.block_end import closed_at_end
from rostether.mechanisms.loopback import is_loopback
from rostether.rosserial.baud_probe import NoBoard
from rostether.serde.store import TypeStore
from rostether.transports.address import Address, SerialAddress, SimulationPauses, TcpAddress, UdpAddress
from rostether.transports.opening import listen, open_transport
from rostether.transports.port_facts import PortFacts, read_port_facts
from rostether.transports.port_holders import find_listener
from rostether.transports.serial_errors import is_pseudo_terminal
from rostether.transports.serial_port import ListPorts
from rostether.transports.transport import Listener, Transport

_STARTING_CODES = frozenset(
    {Code.NOTHING_RECEIVED, Code.TEXT_RECEIVED, Code.WRONG_BAUD, Code.NOISE_RECEIVED, Code.PROTOCOL_VERSION}
)


class Diagnosis(Struct, frozen=True):
    """The results for one address; `board` is None if none answered."""

    address: str
    findings: tuple[Finding, ...]
    board: BoardObservations | None = None
    baud: int | None = None

    @property
    def is_ok(self) -> bool:
        """Whether there is no problem."""
        return not self.findings


class Doctor:
    """Examines links. `report_step` receives progress texts for the user."""

    def __init__(
        self,
        store: TypeStore,
        *,
        watch_s: float = WATCH_S,
        report_step: Callable[[str], object] = lambda _text: None,
        read_facts: Callable[[str], Awaitable[PortFacts]] | None = None,
        list_ports: ListPorts = list,
        open_transport: Callable[[Address], Awaitable[Transport]] = open_transport,
    ) -> None:
        self._store = store
        self._watch_s = watch_s
        self._report_step = report_step
        self._read_facts = read_facts or partial(_read_facts, list_ports)
        self._open = open_transport
        self._loop = asyncio.get_running_loop()

    async def examine(self, address: Address) -> Diagnosis:
        """Examine one link. Raises ConfigError for an unsuitable address."""
        if address.listens:
            return await self._examine_listener(address)
        if isinstance(address, SerialAddress):
            try:
                return await self._examine_serial(address)
            except RostetherError as failure:
                return Diagnosis(str(address), (open_error_finding(failure),), baud=address.baud)
        try:
            transport = await self._open(address)
        except TransportError as failure:
            return Diagnosis(str(address), (cannot_open(failure),))
        return self._diagnosis(address, await self._watch(transport, None))

    async def _examine_serial(self, address: SerialAddress) -> Diagnosis:
        finding = port_finding(await self._read_facts(address.path))
        if finding is not None:
            return Diagnosis(str(address), (finding,), baud=address.baud)
        baud = None if is_pseudo_terminal(address.path) else address.baud
        at = f" at {baud} baud" if baud else ""
        self._report_step(f"listening to {address}{at} ...")
        watched = await self._watch(await self._open(address), baud, address.pauses)
        if baud is None or not _needs_search(watched):
            return self._diagnosis(address, watched, baud)
        return await self._search(address, watched)

    async def _search(self, address: SerialAddress, watched: BoardObservations) -> Diagnosis:
        """Try other baud rates, after no valid data arrived at the address's baud rate."""
        self._report_step("trying other baud rates, for up to half a minute ...")
        # DTR stays as it is from here on, so that the board is not reset each time.
        transport = await self._open(replace(address, reset=False))
        try:
            found = await probe_port(cast("TunableTransport", transport))
        finally:
            transport.close()
            await transport.wait_closed()
        if isinstance(found, NoBoard):
            findings = (_judge_search(address, watched, found), *watched.findings[1:])
            return replace(self._diagnosis(address, watched, address.baud), findings=findings)
        self._report_step(f"a board answers at {found.baud} baud; watching it ...")
        right = replace(address, baud=found.baud, reset=False)
        again = await self._watch(await self._open(right), right.baud)
        if found.baud == address.baud:
            # The board was in its bootloader, or disconnected, during the first check.
            return self._diagnosis(right, again, right.baud)
        wrong = error(
            Code.WRONG_BAUD,
            f"the board uses {found.baud} baud, not {address.baud}",
            f'connect with rostether serve "{address.path}?baud={found.baud}", or change setBaud() in '
            "the sketch",
        )
        return replace(self._diagnosis(right, again, right.baud), findings=(wrong, *again.findings))

    async def _examine_listener(self, address: Address) -> Diagnosis:
        connected: asyncio.Future[Transport] = self._loop.create_future()

        def on_transport(transport: Transport) -> None:
            if connected.done():
                transport.close()
            else:
                connected.set_result(transport)

        try:
            listener: Listener = await listen(address, on_transport, entry=BOARD_ENTRY)
        except RostetherError as failure:
            return Diagnosis(str(address), (await self._why_not_listening(address, failure),))
        async with closed_at_end(listener):
            wait_s = max(self._watch_s, NO_ANSWER_S)
            self._report_step(f"waiting {wait_s:.0f} s for a board to connect to {listener.address} ...")
            try:
                async with asyncio.timeout(wait_s):
                    transport = await connected
            except TimeoutError:
                return Diagnosis(str(address), (_no_board_connected(address, listener.address, wait_s),))
            return self._diagnosis(address, await self._watch(transport, None))

    async def _why_not_listening(self, address: Address, failure: RostetherError) -> Finding:
        if isinstance(address, TcpAddress | UdpAddress):
            kind = "tcp" if isinstance(address, TcpAddress) else "udp"
            holder = await asyncio.to_thread(find_listener, address.port, kind=kind)
            if holder is not None:
                return busy(str(address), (holder,))
        return cannot_open(failure)

    async def _watch(
        self, transport: Transport, baud: int | None, pauses: SimulationPauses | None = None
    ) -> BoardObservations:
        return await watch_board(transport, baud, self._store, watch_s=self._watch_s, pauses=pauses)

    def _diagnosis(self, address: Address, watched: BoardObservations, baud: int | None = None) -> Diagnosis:
        has_answered = watched.view.protocol_version is not None
        return Diagnosis(str(address), watched.findings, watched if has_answered else None, baud)


async def _read_facts(list_ports: ListPorts, path: str) -> PortFacts:
    return await asyncio.to_thread(read_port_facts, path, list_ports)


def _needs_search(watched: BoardObservations) -> bool:
    """Return whether another baud rate may be the reason: readable text arrives only at the right one."""
    codes = {each.code for each in watched.findings}
    return (
        watched.view.protocol_version is None
        and Code.TEXT_RECEIVED not in codes
        and bool(codes & _STARTING_CODES)
    )


def _judge_search(address: SerialAddress, watched: BoardObservations, found: NoBoard) -> Finding:
    first = watched.findings[0]
    if found.text_baud is not None:
        return error(
            Code.TEXT_RECEIVED,
            f"no rosserial frame at any usual baud rate, but text at {found.text_baud} baud "
            f"({show(found.text)}): the sketch prints on this port (Serial.print)",
            "upload a sketch that runs rosserial on this port",
        )
    if first.code is Code.NOTHING_RECEIVED:
        return replace(
            first,
            seen=f"nothing was received from {address}, at {address.baud} or any other usual baud rate",
            next_step="check that the sketch runs rosserial on this port (nh.initNode() in setup(), "
            "nh.spinOnce() in loop()), press the board's reset button, and check that the cable carries data",
        )
    if first.code is Code.PROTOCOL_VERSION:
        return first
    return replace(
        first,
        code=Code.NOISE_RECEIVED,
        seen=f"{first.seen.partition(': probably')[0]}, and no frame at any other usual baud rate",
        next_step="check the ground wire and the sketch's setBaud(); give an unusual rate as ?baud=...",
    )


def _no_board_connected(address: Address, endpoint: str, wait_s: float) -> Finding:
    step = (
        "boards on the network cannot reach loopback; give an address of this machine, for example "
        "tcp://0.0.0.0:11411"
        if isinstance(address, TcpAddress | UdpAddress) and is_loopback(address.host)
        else "check the server address and port in the sketch, its Wi-Fi, and this machine's firewall"
    )
    return error(Code.NOBODY_CONNECTED, f"no board connected to {endpoint} within {wait_s:.0f} s", step)
