"""The actions of one client on ROS 2: the goals that it sends, and the actions that it offers.

An action of ROS 1 is a set of topics, which clients use themselves.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

from rostether.errors import RemoteProtocolError, RostetherError, UnknownNameError
from rostether.gateways.client_json import show
from rostether.gateways.rosbridge.client_subscription import Delivery
from rostether.gateways.rosbridge.request import Request
from rostether.gateways.rosbridge.rosbridge_context import RosbridgeContext
from rostether.gateways.rosbridge.settings import MAX_ACTIONS, MAX_GOALS, check_allowed
from rostether.ros2.actions.server import Ros2ActionServer
from rostether.ros2.actions.types import ActionTypes, GoalCall, GoalStatus
from rostether.ros2.types.native_registry import NativeRegistry

Send = Callable[[dict[str, Any], Delivery], None]

# If a page disconnects, its goals are canceled, so that the robot stops. A server that hangs must not delay
# this for longer.
_CANCEL_LIMIT_S = 2.0


class ClientActions:
    """The actions that one client calls or offers. Methods raise RostetherError."""

    def __init__(self, context: RosbridgeContext, send: Send) -> None:
        self._context = context
        self._send = send
        self._goals: dict[asyncio.Task[None], GoalCall] = {}
        self._by_id: dict[object, GoalCall] = {}
        self._offered: dict[str, _OfferedAction] = {}

    async def send_goal(self, request: Request) -> None:
        """Send a goal; feedback and result are sent to the client when they arrive."""
        action, types = self._action(request, request.word("action_type"))
        goal_id, delivery = request.id, Delivery.read(request)
        if len(self._goals) >= MAX_GOALS:
            raise RemoteProtocolError(
                f"send_action_goal: at most {MAX_GOALS} goals at once are allowed; wait for results"
            )
        if goal_id in self._by_id:
            raise RemoteProtocolError(
                f"send_action_goal: the goal {show(goal_id)} is already active; choose another id"
            )
        forms, feedback = self._context.forms, request.flag("feedback")
        payload = await forms.payload(types.goal, request.fields.get("args") or {}, request)
        answer = {"action": request.word("action"), **({} if goal_id is None else {"id": goal_id})}
        call = GoalCall(self._context.graph, action, types)

        def on_feedback(message: bytes) -> None:
            values = forms.to_json(types.feedback, message)
            self._send({"op": "action_feedback", **answer, "values": values}, delivery)

        async def run() -> None:
            result = {"op": "action_result", **answer}
            try:
                status, message = await call.run(payload, on_feedback if feedback else None)
                values: Any = forms.to_json(types.result, message)
                result |= {"values": values, "status": int(status), "result": True}
            except RostetherError as error:
                result |= {"values": str(error), "status": int(GoalStatus.UNKNOWN), "result": False}
            self._send(result, delivery)

        task = asyncio.ensure_future(run())
        self._goals[task] = call
        if goal_id is not None:
            self._by_id[goal_id] = call
        task.add_done_callback(lambda done: self._ended(done, goal_id))

    async def cancel_goal(self, request: Request) -> None:
        """Cancel a goal that this client has sent."""
        call = self._by_id.get(request.id)
        if call is None:
            raise UnknownNameError(
                f"cancel_action_goal: no goal of this client has the id {show(request.id)}"
            )
        await call.cancel()

    async def advertise(self, request: Request) -> None:
        """Offer an action that the client executes."""
        action, types = self._action(request, request.word("type"))
        if action in self._offered:
            return
        if len(self._offered) >= MAX_ACTIONS:
            raise RemoteProtocolError(
                f"advertise_action: at most {MAX_ACTIONS} actions are allowed; unadvertise some"
            )
        name, type_name = request.word("action"), request.word("type")
        offered = _OfferedAction(self._context, action, types, self._send, (name, type_name))
        await offered.server.open(self._context.graph)
        self._offered[action] = offered

    async def unadvertise(self, request: Request) -> None:
        """Stop offering an action; its goals are aborted."""
        await self._own(request).server.close()
        del self._offered[self._resolve(request)]

    async def feedback(self, request: Request) -> None:
        """Handle the client's feedback of a goal."""
        await self._own(request).feedback(request)

    async def result(self, request: Request) -> None:
        """Handle the client's result of a goal."""
        await self._own(request).result(request)

    async def close(self) -> None:
        """Cancel the goals of the client, and end its actions."""
        calls = [self._cancel_quietly(each) for each in self._goals.values()]
        for task in self._goals:
            task.cancel()
        await asyncio.gather(*calls, *(each.server.close() for each in self._offered.values()))
        self._offered.clear()

    async def _cancel_quietly(self, call: GoalCall) -> None:
        try:
            async with asyncio.timeout(_CANCEL_LIMIT_S):
                await call.cancel()
        except (RostetherError, TimeoutError):
            # The server has ended or hangs.
            return

    def _ended(self, task: asyncio.Task[None], goal_id: object) -> None:
        call = self._goals.pop(task)
        if self._by_id.get(goal_id) is call:
            del self._by_id[goal_id]

    def _action(self, request: Request, type_name: str) -> tuple[str, ActionTypes]:
        registry = self._context.store.registry
        if not isinstance(registry, NativeRegistry):
            raise RemoteProtocolError(
                f"{request.op}: this server is on ROS 1, whose actions are topics; use ROSLIB.ActionClient"
            )
        action = self._resolve(request)
        check_allowed(action, self._context.settings.services_glob, "services_glob")
        return action, ActionTypes.find(registry, type_name)

    def _resolve(self, request: Request) -> str:
        return self._context.graph.resolve(request.word("action"))

    def _own(self, request: Request) -> _OfferedAction:
        offered = self._offered.get(self._resolve(request))
        if offered is None:
            raise UnknownNameError(
                f"{request.op}: this client does not offer {request.word('action')}; advertise it first"
            )
        return offered


class _OfferedAction:
    """One action that a client executes; the client uses strings as goal ids."""

    def __init__(
        self, context: RosbridgeContext, action: str, types: ActionTypes, send: Send, shown: tuple[str, str]
    ) -> None:
        self._forms = context.forms
        self._types = types
        self._send = send
        self._name, self._type_name = shown
        self.server = Ros2ActionServer(
            action,
            types,
            empty_result=self._forms.from_json(types.result, {}),
            on_goal=self._send_goal,
            on_cancel=self._send_cancel,
        )

    async def feedback(self, request: Request) -> None:
        """Publish feedback. Raises UnknownNameError, SerializationError."""
        values = request.fields.get("values") or {}
        payload = await self._forms.payload(self._types.feedback, values, request)
        self.server.feedback(self._goal_id(request), payload)

    async def result(self, request: Request) -> None:
        """End a goal. Raises UnknownNameError, SerializationError."""
        goal_id = self._goal_id(request)
        values = request.fields.get("values")
        is_done = bool(request.fields.get("result", True)) and isinstance(values, dict)
        payload = await self._forms.payload(self._types.result, values, request) if is_done else None
        try:
            status = GoalStatus(request.count("status", GoalStatus.SUCCEEDED if is_done else 0))
        except ValueError:
            status = GoalStatus.ABORTED
        is_final = status in (GoalStatus.SUCCEEDED, GoalStatus.CANCELED, GoalStatus.ABORTED)
        self.server.finish(goal_id, status if is_final else GoalStatus.ABORTED, payload)

    def _goal_id(self, request: Request) -> bytes:
        try:
            return bytes.fromhex(str(request.id).rpartition(":")[2])
        except ValueError:
            raise UnknownNameError(f"{request.op}: no goal has the id {show(request.id)}") from None

    def _send_goal(self, goal_id: bytes, payload: bytes) -> None:
        fields = {
            "op": "send_action_goal",
            "id": self._text_id(goal_id),
            "action": self._name,
            "action_type": self._type_name,
            "args": self._forms.to_json(self._types.goal, payload),
            "feedback": True,
        }
        self._send(fields, Delivery())

    def _send_cancel(self, goal_id: bytes) -> None:
        fields = {"op": "cancel_action_goal", "id": self._text_id(goal_id), "action": self._name}
        self._send(fields, Delivery())

    def _text_id(self, goal_id: bytes) -> str:
        return f"action_goal:{self._name}:{goal_id.hex()}"
