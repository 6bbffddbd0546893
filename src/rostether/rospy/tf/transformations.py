"""tf.transformations: the names that `from tf.transformations import *` gives."""

import math

from rostether.rospy.tf.arcball import (
    Arcball,
    arcball_constrain_to_axis,
    arcball_map_to_sphere,
    arcball_nearest_axis,
)
from rostether.rospy.tf.matrices import (
    compose_matrix,
    decompose_matrix,
    is_same_transform,
    orthogonalization_matrix,
    random_rotation_matrix,
    random_vector,
    reflection_from_matrix,
    reflection_matrix,
    rotation_from_matrix,
    scale_from_matrix,
    scale_matrix,
    shear_from_matrix,
    shear_matrix,
    superimposition_matrix,
)
from rostether.rospy.tf.projections import clip_matrix, projection_from_matrix, projection_matrix
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
from rostether.rospy.tf.rotations import numpy_module as _numpy_module

if (_numpy := _numpy_module()) is not None:
    numpy = _numpy
