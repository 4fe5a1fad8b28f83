"""What the measurements do not determine, in words."""

from __future__ import annotations

import numpy as np

from . import rotations
from .parameters import tensor_vector

UNDETERMINED = 1.0  # sigma of a direction in natural scales: a radian, the whole rate, the largest moment
KNOWN_SHARE = 0.9  # of a direction that is one of those that have a name


class Determined:
    """The covariance of the numbers as far as the measurements determine them, and what they do not."""

    def __init__(self, problem, values, by):
        free = np.flatnonzero(problem.free)
        scales = problem.scales[free]
        _, sizes, directions = np.linalg.svd(by[:, free] * scales, full_matrices=True)
        sizes = np.concatenate([sizes, np.zeros(len(free) - len(sizes))])
        known = sizes > 1 / UNDETERMINED
        known &= sizes > 1e-11 * max(sizes.max(), 1e-300)
        self.covariance = np.zeros((len(problem.numbers),) * 2)
        root = directions[known].T / sizes[known] * scales[:, None]
        self.covariance[np.ix_(free, free)] = root @ root.T
        self.open_directions = directions[~known]
        self.sentences = []
        named = named_directions(problem, values, free, scales)
        basis = self.open_directions.copy()
        for name, direction in named:
            if len(basis) and np.linalg.norm(basis @ direction) > KNOWN_SHARE:
                self.sentences.append(name)
                onto = basis.T @ (basis @ direction)
                onto /= np.linalg.norm(onto)
                basis = basis - np.outer(basis @ onto, onto)
                u, s, v = np.linalg.svd(basis, full_matrices=False)
                basis = v[s > 0.5]
        names = [problem.numbers[k].name for k in free]
        if len(basis):
            share = np.sqrt(np.sum(basis**2, axis=0))
            parts = [names[k] for k in np.argsort(-share) if share[k] > 0.2]
            count = "one combination" if len(basis) == 1 else f"{len(basis)} combinations"
            if len(parts) == len(basis):
                self.sentences.append(f"not determined: {', '.join(parts)}")
            else:
                self.sentences.append(f"not determined: {count} of {', '.join(parts)}")


def named_directions(problem, values, free, scales):
    """Changes of the free numbers that have a name, in natural scales and of length 1: the scale of inertia, and a turn of
    the body about an axis of symmetry."""
    parameters = problem.parameters
    n_body = len(parameters.numbers)
    by_numbers = np.zeros((12, len(problem.numbers)))
    by_numbers[:, :n_body] = parameters.derivative(values[:n_body])
    by_numbers = by_numbers[:, free] * scales
    at = parameters.at(values[:n_body])
    rate, moment = np.linalg.norm(at.omega) or 1.0, np.trace(at.tensor)
    unit = np.concatenate([np.ones(3), np.full(3, rate), np.full(6, moment)])
    out = []

    def add(name, change):
        solution, *_ = np.linalg.lstsq(by_numbers / unit[:, None], change / unit, rcond=1e-10)
        missed = np.linalg.norm(by_numbers / unit[:, None] @ solution - change / unit)
        if missed < 1e-4 * np.linalg.norm(change / unit) and np.linalg.norm(solution) > 0:
            out.append((name, solution / np.linalg.norm(solution)))

    add("not determined: the scale of inertia; the ratios of the moments are", np.concatenate([np.zeros(6), tensor_vector(at.tensor)]))
    moments, axes = np.linalg.eigh(at.tensor)
    for k, (a, b) in enumerate(((1, 2), (2, 0), (0, 1))):
        if abs(moments[a] - moments[b]) < 1e-3 * moments[2]:
            axis = axes[:, k]
            of_tensor = rotations.cross_matrix(axis)
            turned = np.concatenate([axis, np.cross(at.omega, axis), tensor_vector(at.tensor @ of_tensor - of_tensor @ at.tensor)])
            add("not determined: psi, the body's turn about its axis of symmetry", turned)
    return out
