"""topic_tools' mux: publishes one of several topics under one name; a service selects the input.

mux/select (topic_tools/MuxSelect)   mux/add   mux/delete   mux/list     and the older OUT_select
mux/selected (std_msgs/String)       the chosen input, latched; `__none`: none
"""

from __future__ import annotations

import asyncio
from collections.abc import Mapping, Sequence
from functools import partial

from rostether.errors import InvalidNameError, ServiceCallError
from rostether.graph.ports import Level, Subscriber
from rostether.graph.typed_graph import Handler, TypedGraph
from rostether.graph.typed_handles import TypedPublisher
from rostether.msgdef.interface import ANY_MESSAGE
from rostether.nodes.forwarding import LAZY_POLL_S
from rostether.nodes.output_topic import OutputTopic
from rostether.serde.values import Message

NO_INPUT = "__none"
# Each input needs a subscription, and the callers of mux/add must not fill the memory.
MAX_INPUTS = 1_000


class Mux:
    """The node mux; `run` serves until canceled."""

    def __init__(
        self,
        graph: TypedGraph,
        output: str,
        inputs: Sequence[str],
        *,
        initial: str = "",
        lazy: bool = False,
        latch: bool = False,
    ) -> None:
        self._graph = graph
        self._output = OutputTopic(graph.raw, output, latch=latch)
        self._inputs: dict[str, Subscriber | None] = {graph.resolve(each): None for each in inputs}
        self._headers: dict[str, Mapping[str, str]] = {}
        self._lazy = lazy
        self._selected_publisher: TypedPublisher[...] | None = None
        first = initial or next(iter(self._inputs), NO_INPUT)
        known = first != NO_INPUT and graph.resolve(first) in self._inputs
        self._selected = graph.resolve(first) if known else NO_INPUT
        self._first_name = first if known else NO_INPUT

    async def run(self) -> None:
        """Serve until canceled. Raises GraphError."""
        self._selected_publisher = await self._graph.publisher("mux/selected", "std_msgs/String", latch=True)
        self._selected_publisher.publish(data=self._first_name)
        services: dict[str, tuple[str, Handler]] = {
            f"{self._output.topic}_select": ("MuxSelect", self._select),
            "mux/select": ("MuxSelect", self._select),
            "mux/add": ("MuxAdd", self._add),
            "mux/delete": ("MuxDelete", self._delete),
            "mux/list": ("MuxList", self._list),
        }
        for name, (kind, handler) in services.items():
            await self._graph.service_server(name, f"topic_tools/{kind}", handler)
        try:
            while True:
                await self._update_subscriptions()
                await asyncio.sleep(LAZY_POLL_S)
        finally:
            for subscriber in self._inputs.values():
                if subscriber is not None:
                    await subscriber.close()
            await self._output.close()

    async def _update_subscriptions(self) -> None:
        """Open the subscriptions that are needed, and close the others."""
        for topic, subscriber in list(self._inputs.items()):
            is_wanted = self._is_wanted(topic)
            if is_wanted and subscriber is None:
                opened = await self._graph.raw.subscribe(
                    topic,
                    ANY_MESSAGE,
                    partial(self._forward, topic),
                    on_connection=partial(self._handle_connection, topic),
                )
                if topic in self._inputs:
                    self._inputs[topic] = opened
                else:
                    await opened.close()
            elif not is_wanted and subscriber is not None:
                self._inputs[topic] = None
                await subscriber.close()

    def _is_wanted(self, topic: str) -> bool:
        if not self._lazy or not self._output.is_advertised:
            return True
        return topic == self._selected and self._output.subscriber_count > 0

    def _handle_connection(self, topic: str, header: Mapping[str, str]) -> None:
        self._headers[topic] = header
        if topic == self._selected or not self._output.is_advertised:
            self._output.advertise_as(header)

    def _forward(self, topic: str, payloads: Sequence[bytes]) -> None:
        if topic == self._selected:
            self._output.publish(payloads)

    def _select(self, request: Message) -> dict[str, str]:
        previous = "" if self._selected == NO_INPUT else self._selected
        if request.topic == NO_INPUT:
            self._selected = NO_INPUT
        else:
            self._selected = self._known_input(request.topic)
            if self._selected in self._headers:
                self._output.advertise_as(self._headers[self._selected])
        self._graph.log(Level.INFO, f"mux selected input: [{self._selected}]")
        assert self._selected_publisher is not None
        self._selected_publisher.publish(data=request.topic)
        return {"prev_topic": previous}

    def _add(self, request: Message) -> dict[str, str]:
        topic = self._resolve(request.topic)
        if topic in self._inputs:
            raise ServiceCallError(f"{topic} is already an input")
        if len(self._inputs) >= MAX_INPUTS:
            raise ServiceCallError(f"a mux has at most {MAX_INPUTS} inputs; delete one")
        self._inputs[topic] = None
        return {}

    async def _delete(self, request: Message) -> dict[str, str]:
        topic = self._known_input(request.topic)
        if topic == self._selected:
            raise ServiceCallError(f"{topic} is selected; select another input before you delete it")
        subscriber = self._inputs.pop(topic)
        self._headers.pop(topic, None)
        if subscriber is not None:
            await subscriber.close()
        return {}

    def _list(self, _request: Message) -> dict[str, list[str]]:
        return {"topics": list(self._inputs)}

    def _known_input(self, name: str) -> str:
        topic = self._resolve(name)
        if topic not in self._inputs:
            raise ServiceCallError(
                f"{topic} is not an input; the inputs are {', '.join(self._inputs) or 'none'}"
            )
        return topic

    def _resolve(self, name: str) -> str:
        if name == NO_INPUT:
            raise ServiceCallError(f"{NO_INPUT} means no input; choose another name")
        try:
            return self._graph.resolve(name)
        except InvalidNameError as error:
            raise ServiceCallError(str(error)) from error
