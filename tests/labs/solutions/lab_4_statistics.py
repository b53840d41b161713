import numpy as np


# answer: statistics-1
def score(good, acceptable, bad):
    return (good + 0.5 * acceptable) / (good + acceptable + bad)


# answer: statistics-2
def rating_probabilities(predictor, low, high):
    below = 1.0 / (1.0 + np.exp(predictor - np.array([low, high])))
    return np.diff(np.concatenate([[0.0], below, [1.0]]))


# answer: statistics-3
def permutation_p_value(differences):
    count = len(differences)
    signs = 1 - 2 * ((np.arange(2**count)[:, None] >> np.arange(count)) & 1)
    means = np.abs((signs * differences).mean(axis=1))
    return np.mean(means >= abs(np.mean(differences)) - 1e-12)


# answer: statistics-4
def release_force(forces, scores, level):
    return np.interp(level, scores[::-1], forces[::-1])
