"""tf.transformations, as far as nodes use it."""

# ruff: noqa: F401
from rostether.rospy.tf.rotations import (
    concatenate_matrices,
    euler_from_matrix,
    euler_from_quaternion,
    euler_matrix,
    identity_matrix,
    inverse_matrix,
    quaternion_about_axis,
    quaternion_conjugate,
    quaternion_from_euler,
    quaternion_from_matrix,
    quaternion_inverse,
    quaternion_matrix,
    quaternion_multiply,
    quaternion_slerp,
    random_quaternion,
    rotation_matrix,
    translation_from_matrix,
    translation_matrix,
    unit_vector,
    vector_norm,
)
