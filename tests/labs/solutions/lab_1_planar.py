import numpy as np


# answer: planar-1
def cone_edges(normal, friction):
    side = np.array([-normal[1], normal[0]])
    return np.array([normal + friction * side, normal - friction * side])


# answer: planar-2
def min_object_angle(friction):
    return np.pi - 2.0 * np.arctan(friction)


# answer: planar-3
def wrench(point, force, origin):
    arm = point - origin
    return np.array([force[0], force[1], arm[0] * force[1] - arm[1] * force[0]])


# answer: planar-4
def is_force_closure(points, normals, friction):
    chord = (points[1] - points[0]) / np.linalg.norm(points[1] - points[0])
    steepest = np.cos(np.arctan(friction))
    return normals[0] @ chord > steepest and normals[1] @ -chord > steepest
