"""Runs Debian's roslaunch on launch files: JSON cases on stdin, JSON results on stdout."""

import contextlib
import json
import sys
import xmlrpc.client

from rosgraph.names import canonicalize_name, make_global_ns
from roslaunch.config import ROSLaunchConfig
from roslaunch.core import local_machine, setup_env
from roslaunch.xmlloader import XmlLoader

MASTER_URI = "http://localhost:11311"


def plain(value):
    return {"binary": value.data.hex()} if isinstance(value, xmlrpc.client.Binary) else value


def describe_node(node):
    variables = setup_env(node, local_machine(), MASTER_URI, env={"ROS_NAMESPACE": "/callers"})
    return {
        "package": node.package,
        "type": node.type,
        "name": node.name,
        "namespace": node.namespace,
        "args": node.args,
        "remaps": [list(each) for each in node.remap_args],
        "environment": variables,
        "respawn": node.respawn,
        "respawn_delay_s": node.respawn_delay,
        "required": node.required,
        "output": node.output or "log",
        "cwd": node.cwd or "ROS_HOME",
        "launch_prefix": node.launch_prefix or "",
    }


def describe(file, argv):
    config = ROSLaunchConfig()
    loader = XmlLoader()
    loader.ignore_unset_args = False
    try:
        loader.load(file, config, argv=argv, verbose=False)
        config.assign_machines()
    except (Exception, SystemExit) as error:  # noqa: BLE001 - roslaunch raises errors of any class
        return {"error": f"{type(error).__name__}: {error}"}
    return {
        "parameters": {key: plain(param.value) for key, param in config.params.items()},
        "nodes": [describe_node(node) for node in config.nodes],
        # As the parameter server resolves these names.
        "cleared": [make_global_ns(canonicalize_name(each)) for each in config.clear_params],
        "before": [[*each.args[:-1], canonicalize_name(each.args[-1])] for each in config.executables],
        "warnings": len(config.config_errors),
        "arguments": {
            name: [default, doc]
            for name, (doc, default) in loader.root_context.resolve_dict.get("arg_doc", {}).items()
        },
    }


with contextlib.redirect_stdout(sys.stderr):
    results = [describe(case["file"], case["argv"]) for case in json.load(sys.stdin)]
json.dump(results, sys.stdout)
