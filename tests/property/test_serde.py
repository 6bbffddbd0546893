"""Every bundled type: encoded messages decode to equal ones; the layout accepts them, and no changed
bytes.
"""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from effort import effort
from property.message_strategies import messages
from rostether.errors import SerializationError
from rostether.msgdef.registry import Registry
from rostether.serde.store import TypeStore

pytestmark = pytest.mark.slow

STORE = TypeStore(Registry())
SERVICE_MESSAGES = [
    f"{service}{part}" for service in STORE.registry.services() for part in ("Request", "Response")
]
TYPES = STORE.registry.messages() + SERVICE_MESSAGES
SETTINGS = settings(
    max_examples=effort(2, thorough=50),
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)


@pytest.mark.parametrize("name", TYPES)
@SETTINGS
@given(data=st.data())
def test_decoding_undoes_encoding(name: str, data: st.DataObject) -> None:
    codec = STORE.codec(name)
    message = data.draw(messages(codec))
    payload = codec.encode(message)
    assert codec.decode(payload) == message
    assert codec.encode(codec.decode(payload)) == payload
    assert codec.layout.accepts(payload)
    assert codec.layout.fixed_size_bytes in (None, len(payload))
    extended = payload + data.draw(st.binary(min_size=1, max_size=9))
    cut = payload[: data.draw(st.integers(0, max(len(payload) - 1, 0)))]
    assert not codec.layout.accepts(extended)
    assert codec.layout.accepts(cut) is (cut == payload)
    assert codec.layout.accepts_all([payload, extended]) is False
    with pytest.raises(SerializationError):
        codec.decode(extended)


@settings(max_examples=effort(20, 60), deadline=None)
@given(payload=st.binary(max_size=120) | st.lists(st.integers(0, 3), max_size=120).map(bytes))
def test_the_layout_accepts_exactly_the_bytes_that_decode(payload: bytes) -> None:
    for name in TYPES:
        codec = STORE.codec(name)
        accepted = codec.layout.accepts(payload)
        assert codec.layout.accepts_all([payload]) is accepted
        try:
            codec.decode(payload)
        except SerializationError as error:
            assert not accepted
            assert str(error) == codec.layout.explain(payload)
        else:
            assert accepted
