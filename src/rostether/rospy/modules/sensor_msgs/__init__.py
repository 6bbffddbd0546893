"""sensor_msgs: the Python modules of the package, apart from its messages and services."""
