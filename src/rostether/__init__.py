"""Tethers microcontrollers to ROS: serial boards become nodes of a ROS graph, with no ROS installed."""
