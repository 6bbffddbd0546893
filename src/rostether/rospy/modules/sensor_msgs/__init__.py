"""sensor_msgs, beside its messages and services."""
