"""`rostether run`: one node of a package, like rosrun."""

from __future__ import annotations

import os
import shlex

import click

from rostether.cli.dashboard.view import has_browser
from rostether.cli.launch.builtin_nodes import builtin_nodes, replacement_line, view_command
from rostether.cli.launch.node_command import node_command
from rostether.cli.launch.pkg import complete_package_folders, complete_programs, packages_here
from rostether.cli.shell.option_group import add_flag, add_option
from rostether.cli.shell.output import warn, write_line
from rostether.cli.shell.own_command import replace_process
from rostether.cli.shell.verbs import verb
from rostether.rospy.environment import script_environment


@verb(
    "run",
    """
    rostether run mearm_model filter.py
    rostether run mearm_model move.py __name:=mover joint_states:=/arm/joint_states
    rostether run rosserial_python serial_node.py _port:=/dev/ttyACM0 _baud:=115200
    rostether run topic_tools relay /chatter /copy
    rostether run --prefix "nice -n 10" mearm_model filter.py
    """,
    context_settings={"ignore_unknown_options": True, "allow_interspersed_args": False},
)
@add_option("-p --prefix COMMAND", "Run the node through this command.", default="")
@add_flag("-d --debug", "Print the command line that is run.")
@click.argument("package", shell_complete=complete_package_folders)
@click.argument("program", metavar="NODE", shell_complete=complete_programs)
@click.argument("arguments", nargs=-1, type=click.UNPROCESSED, metavar="[ARGUMENT | NAME:=VALUE]...")
def run(prefix: str, debug: bool, package: str, program: str, arguments: tuple[str, ...]) -> None:
    """Run a node of a package, without a build and without a ROS installation.

    Packages are found on ROS_PACKAGE_PATH, in the catkin workspace around this folder, and below it. Nodes
    such as serial_node.py, relay and robot_state_publisher are built in. All arguments after the node's name
    go to the node.
    """
    in_terminal = not has_browser(os.environ)
    if line := replacement_line(package, os.environ, in_terminal=in_terminal):
        warn(line)
        replace_process(view_command(package, arguments, in_terminal=in_terminal), os.environ)
    # Searching a home directory takes time, and built-in nodes are not in a folder.
    is_built_in = (package, program) in builtin_nodes()
    packages = {} if is_built_in else packages_here()
    found = node_command(package, program, packages=packages, environ=os.environ)
    words = [*shlex.split(prefix), *found, *arguments]
    if debug:
        write_line(shlex.join(words))
    replace_process(words, script_environment(os.environ, packages))
