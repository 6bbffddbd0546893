"""The reserved topic ids of the rosserial protocol, and the first id of user topics.

    id       payload                                               direction
    0        empty: "send me your topics"                          host to device
    0        TopicInfo of a publisher                              device to host
    1        TopicInfo of a subscriber                             device to host
    2, 3     TopicInfo of a service server: response, request      device to host
    4, 5     TopicInfo of a service client: request, response      device to host
    6        RequestParam: request (device), response (host)       both
    7        Log                                                   device to host
    10       Time: request (device), answer (host)                 both
    11       empty: stop sending, the host leaves                  host to device
    100 ..   user topics                                           both

Directions are the device's: 2 and 4 announce the topic that the device publishes, 3 and 5 the topic that it
subscribes to. Source: rosserial_msgs/TopicInfo.
"""

from __future__ import annotations

TOPIC_REQUEST = 0
PUBLISHER = 0
SUBSCRIBER = 1
SERVICE_SERVER_RESPONSE = 2
SERVICE_SERVER_REQUEST = 3
SERVICE_CLIENT_REQUEST = 4
SERVICE_CLIENT_RESPONSE = 5
PARAMETER = 6
LOG = 7
TIME = 10
TX_STOP = 11

FIRST_USER_ID = 100
LAST_ID = 0xFFFF

# The ids on which a device announces an endpoint.
ANNOUNCEMENTS = range(PUBLISHER, SERVICE_CLIENT_RESPONSE + 1)

# Announcements of endpoints that the device sends on; on the others it listens.
DEVICE_SENDS_ON = frozenset({PUBLISHER, SERVICE_SERVER_RESPONSE, SERVICE_CLIENT_REQUEST})
