"""KDL's rotation of a revolute joint's child, as robot_state_publisher uses it, for each case on stdin."""

import json
import sys

import PyKDL

rotations = []
for quaternion, axis, position in json.load(sys.stdin):
    origin = PyKDL.Frame(PyKDL.Rotation.Quaternion(*quaternion), PyKDL.Vector(0.1, 0.2, 0.3))
    joint = PyKDL.Joint("joint", origin.p, origin.M * PyKDL.Vector(*axis), PyKDL.Joint.RotAxis)
    rotations.append(list(PyKDL.Segment("segment", joint, origin).pose(position).M.GetQuaternion()))
json.dump(rotations, sys.stdout)
