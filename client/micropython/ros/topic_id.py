"""Topic ids of the protocol; those of a program's topics count up from FIRST_USER_TOPIC."""

ID_PUBLISHER = 0  # TopicInfo; empty and from the host: "send me your topics"
ID_SUBSCRIBER = 1
ID_SERVICE_SERVER = 2  # responses; requests are one more
ID_SERVICE_CLIENT = 4  # requests; responses are one more
ID_PARAMETER_REQUEST = 6
ID_LOG = 7
ID_TIME = 10
ID_TX_STOP = 11
FIRST_USER_TOPIC = 100
