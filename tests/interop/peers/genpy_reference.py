"""Runs genpy and rostopic on the messages given as JSON on standard input, with Debian's Python.

It imports nothing of rostether. The answer is a JSON list with one entry for each request, in order.
"""

import base64
import contextlib
import io
import json
import math
import sys

import genpy
import roslib.message
import rospy
import rostopic
import std_msgs.msg

NOW = genpy.Time(1700000123, 456)
rospy.get_rostime = lambda: NOW


def plain(value):
    if isinstance(value, genpy.Message):
        return {name: plain(getattr(value, name)) for name in value.__slots__}
    if isinstance(value, genpy.rostime.TVal):
        return {"secs": value.secs, "nsecs": value.nsecs}
    if isinstance(value, float) and not math.isfinite(value):
        return "NaN" if math.isnan(value) else "Infinity" if value > 0 else "-Infinity"
    if isinstance(value, (list, tuple, bytes)):
        return [plain(each) for each in value]
    return value


def read(request):
    message_class = roslib.message.get_message_class(request["type"])
    if message_class is None:
        return None
    message = message_class()
    message.deserialize(base64.b64decode(request["payload"]))
    return message


def serialized(message):
    buffer = io.BytesIO()
    message.serialize(buffer)
    return base64.b64encode(buffer.getvalue()).decode()


def type_at(message, path):
    found = None
    message_class = type(message)
    for part in path.strip("/").split("/"):
        found = message_class._slot_types[message_class.__slots__.index(part.split("[")[0])]
        message_class = roslib.message.get_message_class(found.split("[", 1)[0]) if "/" in found else None
    return found


def codec(request):
    message = read(request)
    return message and {"payload": serialized(message), "plain": plain(message)}


def echo(request):
    message = read(request)
    if message is None:
        return None
    path = request.get("path", "")
    no_strings, no_arrays, plot = request["nostr"], request["noarr"], request["plot"]
    callback = rostopic.CallbackEcho(
        "/topic" + path,
        None,
        plot=plot,
        offset_time=request["offset"],
        field_filter_fn=rostopic.create_field_filter(no_strings, no_arrays) if plot else None,
        value_transform_fn=None if plot else rostopic.create_value_transform(no_strings, no_arrays),
        fixed_numeric_width=request["width"],
    )
    output, problems = io.StringIO(), io.StringIO()
    arguments = {"topic": "/topic", "type_information": type_at(message, path) if path else None}
    with contextlib.redirect_stdout(output), contextlib.redirect_stderr(problems):
        callback.callback(message, arguments)
    return {"text": output.getvalue(), "problem": problems.getvalue()}


def fill(request):
    import yaml

    message = roslib.message.get_message_class(request["type"])()
    keys = {"now": NOW, "auto": std_msgs.msg.Header(stamp=NOW)}
    try:
        arguments = [yaml.safe_load(argument) for argument in request["arguments"]]
        genpy.message.fill_message_args(message, arguments, keys=keys)
        return {"payload": serialized(message)}
    except Exception as error:  # noqa: BLE001
        return {"error": type(error).__name__ + ": " + str(error)}


TASKS = {"codec": codec, "echo": echo, "fill": fill}
json.dump([TASKS[request["task"]](request) for request in json.load(sys.stdin)], sys.stdout)
