"""Checks an implementation of the device's side of rosserial against the wire protocol, case by case."""
