"""Uses tf.transformations with matrices that are not rigid, and its Arcball, and prints the results."""

# Written as users write their nodes.
# ruff: noqa: F403, F405

import numpy
from tf.transformations import *


def show(values):
    if hasattr(values, "tolist"):
        values = values.tolist()
    if isinstance(values, (list, tuple)):
        return "[" + ", ".join(show(value) for value in values) + "]"
    return "%.9f" % (values + 0.0 if abs(values) > 1e-12 else 0.0)


def same(one, two):
    return bool(numpy.allclose(one, two, atol=1e-7))


numpy.random.seed(3)
for _ in range(20):
    point, normal, direction, eye = (numpy.random.random(3) - 0.5 for _ in range(4))
    across = numpy.cross(normal, direction)
    cases = [
        (reflection_matrix(point, normal), reflection_from_matrix, reflection_matrix),
        (rotation_matrix(2.5 * point[0], direction, point), rotation_from_matrix, rotation_matrix),
        (scale_matrix(3.1 * eye[1]), scale_from_matrix, scale_matrix),
        (scale_matrix(-1.7, point), scale_from_matrix, scale_matrix),
        (scale_matrix(0.3, point, direction), scale_from_matrix, scale_matrix),
        (projection_matrix(point, normal), projection_from_matrix, projection_matrix),
        (projection_matrix(point, normal, direction), projection_from_matrix, projection_matrix),
        (projection_matrix(point, normal, perspective=eye), projection_from_matrix, projection_matrix),
    ]
    for matrix, parts_of, make in cases:
        print(show(matrix), is_same_transform(make(*parts_of(matrix)), matrix))
    print(show(shear_matrix(point[0], across, point, normal)))
    matrix = projection_matrix(point, normal, perspective=eye, pseudo=True)
    print(show(matrix), is_same_transform(projection_matrix(*projection_from_matrix(matrix, True)), matrix))
    matrix = compose_matrix(point * 3, normal, direction * 3, eye, [0.1, 0.2, -0.1, 1.2])
    parts = decompose_matrix(matrix)
    print(show(matrix), [show(part) for part in parts], same(compose_matrix(*parts), matrix))
    print(show(inverse_matrix(matrix)), show(compose_matrix(angles=direction, translate=eye)))
    points = numpy.random.random((3, 9)) - 0.5
    moved = (rotation_matrix(1, direction, point) @ numpy.vstack([2 * points, numpy.ones(9)]))[:3]
    print(show(superimposition_matrix(points, moved)), show(superimposition_matrix(points, moved, True)))
    rough = moved + 0.1 * (numpy.random.random((3, 9)) - 0.5)
    print(
        show(superimposition_matrix(points, rough, usesvd=True)), show(superimposition_matrix(rough, -points))
    )
    print(show(random_quaternion(numpy.abs(point))), show(random_rotation_matrix(numpy.abs(point))))
    print(show(vector_norm(points)), show(vector_norm(points, axis=1)), show(unit_vector(points, axis=0)))
    one, two = random_quaternion(numpy.abs(point)), random_quaternion(numpy.abs(eye))
    print(
        [show(quaternion_slerp(one, two, 0.3, spin, short)) for spin in (0, 1, 2) for short in (True, False)]
    )
    ball, other = Arcball(), Arcball(one)
    for each in (ball, other, Arcball(quaternion_matrix(two))):
        each.place([320, 320], 320)
        each.setaxes([1, 2, 3], [-1, 1, 0])
        each.setconstrain(each is other)
        each.down([300 + 200 * eye[0], 200])
        each.drag([300, 200 + 400 * eye[1]])
        before = each.matrix()
        each.next()
        print(each.getconstrain(), show(before), show(each.matrix()))
    print(show(arcball_map_to_sphere(400 * point[:2], [10, 20], 90)))
    print(show(arcball_constrain_to_axis(unit_vector(point), unit_vector(eye))))
print(show(clip_matrix(-1, 2, -3, 5, 0.2, 7)), show(clip_matrix(-1, 2, -3, 5, 0.2, 7, perspective=True)))
print(show(orthogonalization_matrix((10.0, 11.0, 12.0), (80.0, 95.0, 110.0))), random_vector(7).shape)
into = numpy.zeros(3)
print(
    unit_vector([1, 2, 3], out=into), show(into), is_same_transform(identity_matrix(), 3 * identity_matrix())
)
for label, function in (
    ("no reflection", lambda: reflection_from_matrix(translation_matrix((1, 2, 3)))),
    ("no rotation", lambda: rotation_from_matrix(scale_matrix(2.5))),
    ("no shear", lambda: shear_matrix(0.3, (1, 0, 0), (0, 0, 0), (1, 0, 0))),
    ("no inverse", lambda: decompose_matrix(numpy.zeros((4, 4)))),
    ("no volume", lambda: clip_matrix(2, 1, 0, 1, 1, 2)),
    ("behind", lambda: clip_matrix(0, 1, 0, 1, -1, 2, perspective=True)),
):
    try:
        print(label, function())
    except ValueError:
        print(label, "raises ValueError")
