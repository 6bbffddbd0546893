"""tf_conversions: only `transformations`; the conversions to PyKDL are not available."""

from importlib import import_module as _import_module

transformations = _import_module("tf.transformations")
