"""The host's answer to a request for a parameter."""


def read_parameter(reader):
    """Read the response of RequestParam: int32[] ints, float32[] floats, string[] strings.

    Only one of them has elements. Returns a single value; a list of several values; None if there is no such
    parameter. Raises MisfitError.
    """
    ints = reader.array("i")
    floats = reader.array("f")
    values = reader.strings() or list(ints) or list(floats)
    reader.finish()
    if len(values) > 1:
        return values
    return values[0] if values else None
