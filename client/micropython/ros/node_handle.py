"""`NodeHandle`: negotiation, time, logs and parameters."""

from struct import pack_into

from ros.clock import Clock
from ros.parameters import read_parameter
from ros.receive_window import OVERHEAD_BYTES, ReceiveWindow
from ros.ticks import sleep_ms, ticks_diff, ticks_ms
from ros.topic_id import (
    FIRST_USER_TOPIC,
    ID_LOG,
    ID_PARAMETER_REQUEST,
    ID_PUBLISHER,
    ID_TIME,
    ID_TX_STOP,
)
from ros.wire import MisfitError, Writer

SPIN_OK = 0
SPIN_ERR = -1
SPIN_TIMEOUT = -2

_SYNC_PERIOD_MS = 2200
# Together with _SYNC_PERIOD_MS: after 9 to 11 s without an answer, the host has disconnected.
_MAX_UNANSWERED = 4
# After a gap of this length inside a frame, its rest was lost. The pauses of a Wi-Fi network are shorter.
_GAP_MS = 500
# TCP loses no byte, but the rest is late while lost packets are sent again: for the fourth time after 3 s.
_RELIABLE_GAP_MS = 5000
# A host that searches for boards sends other version bytes, and so does noise. A burst needs one answer.
_ANSWER_PAUSE_MS = 20
# The time limit of a spinOnce: a line that never pauses must not stop the program.
_SPIN_TIMEOUT_MS = 1000
# If the transmitter accepts no byte for this time, it is not connected: one byte takes 1 ms at 9600 baud.
_STALL_MS = 100
# The limit of nested callbacks, each of which waits in a spinOnce. More would fill a board's stack.
_MAX_DEPTH = 3

# What _keep_in_touch must react to, as bits: a host that searches for boards, a time without a request for
# the topics, and a request for the topics.
_PROBED = 1
_INTRODUCTION_DUE = 2
_ANSWER_DUE = 4


class NodeHandle:
    """A node on some hardware, by default the board's USB port.

    `input_size` is the length of the longest message that it can receive, and `output_size` of the longest
    that it can send, in bytes.

    The hardware has `read(view, at)`, which reads the available bytes into a memoryview from `at` on, without
    waiting, and returns their number. It also has `write(view)`, which returns how many bytes were accepted.

    Hardware that reconnects by itself, and loses no byte of a connection, has `relinked()`: it returns
    whether the link was lost or made since the last call. Between this change and the call, it must not read
    or write bytes. If the hardware has `relink()`, the node calls it when the host is silent for about 10 s,
    because a network can fail without ending the connection. If it has `interrupt()`, the node calls it after
    a Ctrl-C between two frames.
    """

    def __init__(self, hardware=None, input_size=512, output_size=512):
        self._hardware = hardware
        self._relinked = self._relink = self._interrupt = None
        self._gap_ms = _GAP_MS
        # The buffer must hold a time.
        self._window = ReceiveWindow(max(input_size, 16))
        self._writer = Writer(output_size + OVERHEAD_BYTES)
        self._endpoints = []
        self._receivers = {}
        self._next_id = FIRST_USER_TOPIC
        self._connected = False
        self._due = 0
        self._unanswered = 0
        self._awaits_time = False
        self._stalled = False
        self._depth = 0
        self._parameter = None
        self._received_ms = self._requested_ms = ticks_ms()
        self._clock = Clock(self._received_ms)

    def initNode(self):
        """Start; the next spinOnce introduces the node to the host."""
        if self._hardware is None:
            from ros.usb import usb_hardware

            self._hardware = usb_hardware()
        self._relinked = getattr(self._hardware, "relinked", None)
        if self._relinked:
            self._gap_ms = _RELIABLE_GAP_MS
        self._relink = getattr(self._hardware, "relink", None)
        self._interrupt = getattr(self._hardware, "interrupt", None)
        self._window.forget()
        self._contact_again()

    def getHardware(self):
        """Return the hardware."""
        return self._hardware

    def connected(self):
        """Return whether a host is connected and knows this node's topics."""
        return self._connected

    def dropped(self):
        """Return the number of frames that were damaged, had an unknown topic, or could not be sent."""
        return self._window.dropped

    def now(self):
        """Return the host's time; before its first answer, the time since the node was created."""
        return self._clock.at(ticks_ms())

    def setNow(self, moment):
        """Set the clock to a Time, which is valid until the host's next answer."""
        self._clock.set(moment, ticks_ms())

    def advertise(self, publisher):
        """Announce a Publisher."""
        self._add(publisher)

    def subscribe(self, subscriber):
        """Announce a Subscriber."""
        self._add(subscriber)

    def advertiseService(self, server):
        """Announce a ServiceServer."""
        self._add(server)

    def serviceClient(self, client):
        """Announce a ServiceClient."""
        self._add(client)

    def negotiateTopics(self):
        """Announce all topics and services to the host."""
        for each in self._endpoints:
            each.announce()
        self._connected = True

    def requestSyncTime(self):
        """Request the host's time."""
        self._requested_ms = ticks_ms()
        self._clock.advance(self._requested_ms)
        self._awaits_time = True
        writer = self._begin()
        # A time, which the host ignores.
        writer.number("Q", 0)
        self._finish(ID_TIME)

    def logdebug(self, text):
        """Log a text at level debug."""
        self._log(0, text)

    def loginfo(self, text):
        """Log a text at level info."""
        self._log(1, text)

    def logwarn(self, text):
        """Log a text at level warn."""
        self._log(2, text)

    def logerror(self, text):
        """Log a text at level error."""
        self._log(3, text)

    def logfatal(self, text):
        """Log a text at level fatal."""
        self._log(4, text)

    def getParam(self, name, timeout_ms=1000):
        """Return a parameter of the host: a number, a text, or a list of them. A boolean is 0 or 1.

        Returns None, and logs a warning on the host, if there is no such parameter, or no answer within
        `timeout_ms`.
        """
        writer = self._begin()
        writer.string(name)
        self._finish(ID_PARAMETER_REQUEST)
        self._parameter = waiting = []
        self.spin_while(lambda: self._parameter is waiting and not waiting, timeout_ms)
        self._parameter = None
        if not waiting:
            self.logwarn("Failed to get param: timeout expired")
            return None
        if waiting[0] is None:
            self.logwarn("Failed to get param: no " + name)
        return waiting[0]

    def spinOnce(self):
        """Read received bytes, and run the callbacks for them.

        Returns SPIN_OK; SPIN_ERR if the host requested the topics; SPIN_TIMEOUT if the time limit ended it
        before all bytes were handled.
        """
        window = self._window
        began_ms = now_ms = ticks_ms()
        while self._depth < _MAX_DEPTH:
            topic_id = window.next()
            if topic_id >= 0:
                self._handle(topic_id)
            elif window.fill(self._hardware):
                self._received_ms = now_ms
            else:
                break
            now_ms = ticks_ms()
            if ticks_diff(now_ms, began_ms) > _SPIN_TIMEOUT_MS:
                self._keep_in_touch(now_ms)
                return SPIN_TIMEOUT
        if self._relinked and self._relinked():
            window.forget()
            self._contact_again()
        elif not window.empty() and ticks_diff(now_ms, self._received_ms) >= self._gap_ms:
            # The rest of the frame was lost.
            window.drop()
        if self._interrupt and window.interrupted:
            window.interrupted = False
            self._interrupt()
        return self._keep_in_touch(now_ms)

    def spin_while(self, condition, timeout_ms):
        """Spin while `condition()` is true, but at most for `timeout_ms`."""
        began_ms = ticks_ms()
        while condition() and ticks_diff(ticks_ms(), began_ms) < timeout_ms:
            self.spinOnce()
            if condition() and self._window.empty():
                sleep_ms(1)

    def send(self, topic_id, message):
        """For publishers and services: send a message.

        Returns the number of bytes sent; 0 without a host; -1 if the message is too long or was not accepted
        by the line.
        """
        # After a reset, the host's answer may be among the received bytes. Inside a callback, they are
        # already being handled.
        if not self._connected and self._depth == 0:
            self.spinOnce()
        if not self._connected:
            return 0
        try:
            message.serialize(self._begin())
        except MisfitError:
            self._window.dropped += 1
            return -1
        return self._finish(topic_id)

    def announce(self, role, topic_id, topic, message_class):
        """For endpoints: announce a topic, or the requests or responses of a service.

        `role` is the topic id of the announcement.
        """
        writer = self._begin()
        writer.number("H", topic_id)
        writer.string(topic)
        writer.string(message_class._type)
        writer.string(message_class._md5sum)
        largest = self._window.largest_payload if role & 1 else len(writer.buffer)
        writer.number("I", largest)
        self._finish(role)

    def _add(self, endpoint):
        if endpoint.id:
            return
        endpoint.attach(self, self._next_id)
        self._next_id += endpoint.id_count
        self._endpoints.append(endpoint)
        if hasattr(endpoint, "receive"):
            self._receivers[endpoint.id] = endpoint
        if self._connected:
            endpoint.announce()

    def _contact_again(self):
        self._connected = False
        self._unanswered = 0
        self._due = 0
        self._requested_ms = ticks_ms() - _SYNC_PERIOD_MS

    def _log(self, level, text):
        try:
            writer = self._begin()
            writer.number("B", level)
            writer.string(text)
        except MisfitError:
            self._window.dropped += 1
        else:
            self._finish(ID_LOG)

    def _handle(self, topic_id):
        self._depth += 1
        try:
            self._dispatch(topic_id)
        except MisfitError:
            self._window.dropped += 1
        finally:
            self._depth -= 1

    def _dispatch(self, topic_id):
        reader = self._window.reader
        length = reader.end - reader.at
        if topic_id == ID_PUBLISHER:
            self._due |= _ANSWER_DUE
        elif topic_id == ID_TIME:
            if length == 8:
                self._handle_time(reader)
        elif topic_id == ID_TX_STOP:
            self._connected = False
        elif topic_id == ID_PARAMETER_REQUEST:
            value = read_parameter(reader)
            if self._parameter is not None:
                self._parameter.append(value)
        elif topic_id in self._receivers:
            self._receivers[topic_id].receive(reader)
        else:
            self._window.dropped += 1

    def _handle_time(self, reader):
        now_ms = ticks_ms()
        # Assumes that the host read its clock halfway between request and answer.
        age_ms = ticks_diff(now_ms, self._requested_ms) // 2 if self._awaits_time else 0
        sec = reader.number("I")
        self._clock.follow(sec, reader.number("I"), now_ms, age_ms)
        self._awaits_time = False
        self._unanswered = 0
        if not self._connected:
            self._due |= _INTRODUCTION_DUE

    def _keep_in_touch(self, now_ms):
        """Answer the host's requests for topics, repeated ones once. Without a request, request the time."""
        due = self._due
        self._due = 0
        if self._window.read_foreign() and not self._connected:
            due |= _PROBED
        silent_ms = ticks_diff(now_ms, self._requested_ms)
        if silent_ms < _SYNC_PERIOD_MS and (due == 0 or (due == _PROBED and silent_ms <= _ANSWER_PAUSE_MS)):
            return SPIN_OK
        if due & _ANSWER_DUE:
            self.requestSyncTime()
            self.negotiateTopics()
            self._unanswered = 0
            return SPIN_ERR
        if due & _INTRODUCTION_DUE:
            self.negotiateTopics()
        elif self._unanswered == _MAX_UNANSWERED:
            self._connected = False
            if self._relink:
                self._relink()
        else:
            self._unanswered += 1
        self.requestSyncTime()
        return SPIN_OK

    def _begin(self):
        writer = self._writer
        writer.at = OVERHEAD_BYTES - 1
        return writer

    def _finish(self, topic_id):
        """Send the written bytes as a frame.

        Returns the number of bytes sent; -1 if the message is too long or was not accepted by the line.
        """
        writer = self._writer
        end = writer.at
        try:
            writer.room(1)
        except MisfitError:
            self._window.dropped += 1
            return -1
        length = end - OVERHEAD_BYTES + 1
        buffer = writer.buffer
        pack_into(
            "<BBHBH", buffer, 0, 0xFF, 0xFE, length, 255 - ((length & 255) + (length >> 8) & 255), topic_id
        )
        buffer[end] = 255 - (sum(writer.view[5:end]) & 255)
        return end + 1 if self._transmit(writer.view[: end + 1]) else -1

    def _transmit(self, data):
        """Write bytes, reading while the transmitter is full. Return False once the line accepts no more."""
        write = self._hardware.write
        began_ms = ticks_ms()
        while True:
            count = write(data)
            if count == len(data):
                self._stalled = False
                return True
            if count:
                self._stalled = False
                data = data[count:]
                began_ms = ticks_ms()
            elif self._stalled or ticks_diff(ticks_ms(), began_ms) > _STALL_MS:
                # After a stall, the next frame does not wait again.
                self._stalled = True
                self._window.dropped += 1
                return False
            if self._window.fill(self._hardware):
                self._received_ms = ticks_ms()
