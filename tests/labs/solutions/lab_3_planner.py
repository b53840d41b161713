import numpy as np


# answer: planner-1
def axis_approaches(axis, steps):
    first = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    first = first / np.linalg.norm(first)
    second = np.cross(axis, first)
    angles = 2.0 * np.pi * np.arange(steps) / steps
    return np.outer(np.cos(angles), first) + np.outer(np.sin(angles), second)


# answer: planner-2
def rim_approach(center, centroid, across):
    return across if across @ (centroid - center) > 0.0 else -across


# answer: planner-3
def hand_rotation(palm, axis, approach, closing):
    hand = np.column_stack([palm, axis, np.cross(palm, axis)])
    target = np.column_stack([approach, closing, np.cross(approach, closing)])
    return target @ hand.T


# answer: planner-4
def yield_interval(found, tested):
    z, share = 1.96, found / tested
    middle = (share + z**2 / (2 * tested)) / (1 + z**2 / tested)
    half = z / (1 + z**2 / tested)
    half = half * np.sqrt(share * (1 - share) / tested + z**2 / (4 * tested**2))
    return max(0.0, middle - half), min(1.0, middle + half)
