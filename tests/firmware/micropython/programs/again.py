"""Reads messages and writes them back.

Each line of standard input has the package, the kind, the class, `Request` or `Response` of a service, and
the bytes.
"""

import gc
import sys
from binascii import hexlify, unhexlify

from ros.wire import MisfitError, Reader, Writer

for line in sys.stdin:
    package, kind, name, part, text = line.rstrip("\n").split(" ")
    module = __import__(package + "." + kind, None, None, (name,))
    message_class = getattr(module, name)
    message = (getattr(message_class, part) if part else message_class)()
    data = unhexlify(text)
    reader = Reader(bytearray(data))
    reader.end = len(data)
    writer = Writer(len(data))
    try:
        message.deserialize(reader)
        reader.finish()
        message.serialize(writer)
        print(hexlify(writer.view[: writer.at]).decode())
    except MisfitError as error:
        print(error)
    gc.collect()
