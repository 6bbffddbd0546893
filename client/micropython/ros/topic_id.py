"""The topic ids of the protocol and their content; user topics count up from FIRST_USER_TOPIC."""

ID_PUBLISHER = 0  # TopicInfo; without content from the host: a request for all topics
ID_SUBSCRIBER = 1
ID_SERVICE_SERVER = 2  # responses; the id for requests is one higher
ID_SERVICE_CLIENT = 4  # requests; the id for responses is one higher
ID_PARAMETER_REQUEST = 6
ID_LOG = 7
ID_TIME = 10
ID_TX_STOP = 11
FIRST_USER_TOPIC = 100
