import numpy as np


# answer: medial-1
def object_angle(center, touch_points):
    arms = touch_points - center
    arms = arms / np.linalg.norm(arms, axis=1, keepdims=True)
    return np.arccos(np.clip(arms @ arms.T, -1.0, 1.0).min())


# answer: medial-2
def ball_radius(point, normal, other):
    gap = point - other
    return (gap @ gap) / (2.0 * normal @ gap)


# answer: medial-3
def shrink(point, normal, points):
    radius = 10.0
    while True:
        center = point - radius * normal
        distance = np.linalg.norm(points - center, axis=1)
        nearest = points[np.argmin(distance)]
        if distance.min() > radius - 1e-9:
            return center
        gap = point - nearest
        radius = (gap @ gap) / (2.0 * normal @ gap)


# answer: medial-4
def symmetry_ratio(centers):
    values = np.linalg.eigvalsh(np.cov((centers - centers.mean(axis=0)).T))
    return values[1] / values[2]
