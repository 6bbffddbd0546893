"""Checks a device implementation of rosserial against the wire protocol, case by case."""
