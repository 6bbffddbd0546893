"""The demo board: a small robot's sketch in Python, without hardware or toolchain.

    topic         type               rate    content
    toggle_led    std_msgs/Empty     in      turns the LED on or off
    led           std_msgs/Bool      1 Hz    the LED, and immediately when it changes
    ultrasound    sensor_msgs/Range  20 Hz   an HC-SR04 with a person walking in front
    imu_data      sensor_msgs/Imu    40 Hz   the robot's turn rate, acceleration and orientation
    /tf           tf/tfMessage       20 Hz   odom -> base_link, a circle on the floor; base_link -> ultrasound
    count         std_msgs/UInt32    1 Hz    a counter

Services: `set_led` (std_srvs/SetBool) and `test_srv` (rosserial_arduino/Test). Parameters: `~blink_hz`, how
often the LED blinks by itself (0: never), and `~frame_id`, the robot's frame (default: base_link). The board
logs when it is ready and when a command switches the LED.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable
from random import Random
from typing import Any

from msgspec import Struct

from rostether.device import Device
from rostether.device.parameters import DeviceParam
from rostether.errors import TransportTimeoutError, UnknownNameError
from rostether.mechanisms.block_end import task_beside
from rostether.serde.values import Message
from rostether.simulation.motion import CircleDrive, Quaternion, Vector
from rostether.simulation.ultrasound import FIELD_OF_VIEW, MAX_RANGE, MIN_RANGE, Obstacle, Ultrasound

# The periods are multiples of each other, so that one wake-up serves several tasks.
RANGE_HZ = 20.0
IMU_HZ = 40.0
TF_HZ = 20.0
LED_HZ = 1.0
COUNT_HZ = 1.0

ULTRASOUND_FRAME = "ultrasound"
ULTRASOUND_POSITION = Vector(0.1, 0.0, 0.05)
ODOMETRY_FRAME = "odom"
ROBOT_FRAME = "base_link"
# Faster blinking is not visible, and would fill a slow line.
MAX_BLINK_HZ = 50.0

# An MPU-6050's noise at 40 Hz.
_TURN_RATE_NOISE = 0.001
_ACCELERATION_NOISE = 0.03
_ORIENTATION_VARIANCE = 1e-4


class _Periodic(Struct):
    action: Callable[[float], None]
    period_s: float
    due_s: float


class VirtualBoard:
    """Declares the demo's endpoints on a device and runs the sketch; the same `seed` gives the same noise.

    `led` and `count` are the current values of these topics.
    """

    def __init__(
        self,
        device: Device,
        *,
        clock: Callable[[], float] | None = None,
        obstacle: Obstacle | None = None,
        seed: int = 0,
    ) -> None:
        self.led = False
        self.count = 0
        self._device = device
        self._clock = clock if clock is not None else asyncio.get_running_loop().time
        self._booted_s = self._clock()
        self._rng = Random(seed)  # noqa: S311 - noise, not a secret
        self._drive = CircleDrive()
        self._ultrasound = Ultrasound(self._rng, obstacle or Obstacle())
        self._frame_id = ROBOT_FRAME
        self._led = device.publisher("led", "std_msgs/Bool")
        self._range = device.publisher("ultrasound", "sensor_msgs/Range")
        self._imu = device.publisher("imu_data", "sensor_msgs/Imu")
        self._tf = device.publisher("/tf", "tf/tfMessage")
        self._count = device.publisher("count", "std_msgs/UInt32")
        self._range_message = self._range.message_class(
            radiation_type=0, field_of_view=FIELD_OF_VIEW, min_range=MIN_RANGE, max_range=MAX_RANGE
        )
        self._range_message.header.frame_id = ULTRASOUND_FRAME
        self._imu_message = self._imu.message_class(
            orientation_covariance=_diagonal(_ORIENTATION_VARIANCE),
            angular_velocity_covariance=_diagonal(_TURN_RATE_NOISE**2),
            linear_acceleration_covariance=_diagonal(_ACCELERATION_NOISE**2),
        )
        self._tf_message = self._tf.message_class(
            transforms=[device.message("geometry_msgs/TransformStamped") for _ in range(2)]
        )
        robot, sensor = self._tf_message.transforms
        robot.header.frame_id = ODOMETRY_FRAME
        sensor.child_frame_id = ULTRASOUND_FRAME
        _set_vector(sensor.transform.translation, ULTRASOUND_POSITION)
        sensor.transform.rotation.w = 1.0
        device.subscriber("toggle_led", "std_msgs/Empty", lambda _message: self._set_led(not self.led))
        device.service_server("set_led", "std_srvs/SetBool", self._serve_set_led)
        device.service_server(
            "test_srv", "rosserial_arduino/Test", lambda request: {"output": f"hello, {request.input}"}
        )
        self._blink = _Periodic(self._blink_once, float("inf"), float("inf"))
        self._tasks = [
            self._every(RANGE_HZ, self._publish_range),
            self._every(IMU_HZ, self._publish_imu),
            self._every(TF_HZ, self._publish_tf),
            self._every(LED_HZ, self._publish_led),
            self._every(COUNT_HZ, self._publish_count),
            self._blink,
        ]

    def step(self, now_s: float) -> float:
        """Do the tasks that are due at `now_s`; return when to call again. Missed repetitions are skipped."""
        for task in self._tasks:
            if task.due_s <= now_s:
                task.action(now_s)
                task.due_s += task.period_s
                if task.due_s <= now_s:
                    task.due_s = now_s + task.period_s
        return min(task.due_s for task in self._tasks)

    async def run(self) -> None:
        """Run whenever a host is connected, until canceled; each new connection gets a log message."""
        while True:
            await self._device.wait_connected()
            async with task_beside(self._report_ready()):
                while self._device.connected:
                    due_s = self.step(self._clock())
                    await asyncio.sleep(max(0.0, due_s - self._clock()))

    async def read_parameters(self) -> None:
        """Read `~blink_hz` and `~frame_id` from the host; unset or invalid values have no effect."""
        blink_hz = await self._get_param("~blink_hz")
        if isinstance(blink_hz, int | float) and 0 <= blink_hz <= MAX_BLINK_HZ:
            self._blink.period_s = 0.5 / blink_hz if blink_hz else float("inf")
            self._blink.due_s = self._clock() + self._blink.period_s
        elif blink_hz is not None:
            self._device.logwarn(f"~blink_hz is {blink_hz!r}; write a number from 0 to {MAX_BLINK_HZ:g}")
        frame_id = await self._get_param("~frame_id")
        if isinstance(frame_id, str) and frame_id:
            self._frame_id = frame_id

    async def _report_ready(self) -> None:
        self._device.loginfo("virtual board ready")
        await self.read_parameters()

    async def _get_param(self, name: str) -> DeviceParam | None:
        with contextlib.suppress(UnknownNameError, TransportTimeoutError):
            return await self._device.get_param(name)
        return None

    def _every(self, rate_hz: float, action: Callable[[float], None]) -> _Periodic:
        return _Periodic(action, 1.0 / rate_hz, self._booted_s)

    def _set_led(self, on: bool) -> None:
        self.led = on
        self._led.publish(data=on)
        self._device.loginfo(f"LED {'on' if on else 'off'}")

    def _blink_once(self, _now_s: float) -> None:
        self.led = not self.led
        self._led.publish(data=self.led)

    def _serve_set_led(self, request: Message) -> dict[str, Any]:
        changed = request.data != self.led
        self._set_led(request.data)
        return {
            "success": True,
            "message": f"LED {'on' if self.led else 'off'}{'' if changed else ' already'}",
        }

    def _publish_led(self, _now_s: float) -> None:
        self._led.publish(data=self.led)

    def _publish_count(self, _now_s: float) -> None:
        self._count.publish(data=self.count)
        self.count = (self.count + 1) & 0xFFFFFFFF

    def _publish_range(self, now_s: float) -> None:
        reading = self._range_message
        reading.header.stamp = self._device.now()
        reading.range = self._ultrasound.measure(now_s)
        self._range.publish(reading)

    def _publish_imu(self, now_s: float) -> None:
        time_s = now_s - self._booted_s
        values = self._drive.imu_values(time_s)
        imu = self._imu_message
        imu.header.stamp = self._device.now()
        imu.header.frame_id = self._frame_id
        _set_rotation(imu.orientation, self._drive.pose(time_s).orientation)
        _set_vector(imu.angular_velocity, self._noisy(values.turn_rate, _TURN_RATE_NOISE))
        _set_vector(imu.linear_acceleration, self._noisy(values.acceleration, _ACCELERATION_NOISE))
        self._imu.publish(imu)

    def _publish_tf(self, now_s: float) -> None:
        pose = self._drive.pose(now_s - self._booted_s)
        robot, sensor = self._tf_message.transforms
        robot.header.stamp = sensor.header.stamp = self._device.now()
        robot.child_frame_id = sensor.header.frame_id = self._frame_id
        _set_vector(robot.transform.translation, pose.position)
        _set_rotation(robot.transform.rotation, pose.orientation)
        self._tf.publish(self._tf_message)

    def _noisy(self, vector: Vector, deviation: float) -> Vector:
        gauss = self._rng.gauss
        return Vector(*(value + gauss(0.0, deviation) for value in vector))


def _set_vector(message: Message, vector: Vector) -> None:
    message.x, message.y, message.z = vector


def _set_rotation(message: Message, rotation: Quaternion) -> None:
    message.x, message.y, message.z, message.w = rotation


def _diagonal(variance: float) -> list[float]:
    return [variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, variance]
