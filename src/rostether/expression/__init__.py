"""Expressions that users type, evaluated over a whitelisted syntax tree and within limits."""
