from __future__ import annotations

from rostether.pictures.digraph import Digraph, Edge, Shape, Vertex, dot, draw
from rostether.pictures.scene import Line, Text

NODE = Vertex("n", "/node", Shape.ELLIPSE)
TOPIC = Vertex("t", "/topic", Shape.BOX)


def test_dot_quotes_special_characters() -> None:
    odd = Vertex('a"b\\', 'say "hi"\n', Shape.BOX)
    text = dot(Digraph([NODE, odd], [Edge("n", odd.key, "x")]))
    assert '  "a\\"b\\\\" [label="say \\"hi\\"\\n", shape=box];' in text.splitlines()
    assert '  "n" -> "a\\"b\\\\" [label="x"];' in text.splitlines()


def test_a_picture_contains_all_labels() -> None:
    scene = draw(Digraph([NODE, TOPIC], [Edge("n", "t"), Edge("t", "n")]))
    texts = [item for item in scene.items if isinstance(item, Text)]
    assert [item.text for item in texts] == ["/node", "/topic"]
    points = [point for item in scene.items if isinstance(item, Line) for point in item.points]
    assert all(0 <= x <= scene.width and 0 <= y <= scene.height for x, y in points)
    heads = [item for item in scene.items if isinstance(item, Line) and item.fill and len(item.points) == 3]
    assert len(heads) == 2


def test_labels_have_their_own_lines() -> None:
    other = Vertex("o", "/other", Shape.ELLIPSE)
    edges = [Edge("n", "o", "/a"), Edge("n", "o", "/b"), Edge("n", "n", "/loop"), Edge("n", "n")]
    scene = draw(Digraph([NODE, other], edges))
    places = {item.text: (item.x, item.y) for item in scene.items if isinstance(item, Text)}
    assert set(places) == {"/node", "/other", "/a", "/b", "/loop"}
    assert len(set(places.values())) == 5
    assert places["/node"][0] < places["/a"][0] < places["/other"][0]
