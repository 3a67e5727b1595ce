"""How well found features agree with true planes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Agreement:
    """Shares from 0 to 1.

    Attributes
    ----------
    recall : float
        True planes that a feature matches: intersection over union of their points above one half. Such a
        match is unique on both sides.
    precision : float
        Features that match a true plane.
    right : float
        Points of true planes that are in the feature matched to theirs.
    strays : float
        Outliers that are in a feature.
    """

    recall: float
    precision: float
    right: float
    strays: float


def agreement(labels: NDArray[np.int32], truth: NDArray[np.int32]) -> Agreement:
    """Compare labels of the same points, negative for none.

    Parameters
    ----------
    labels, truth : (N,) int32
        Found and true; numbers from 0 without gaps.
    """
    found_counts = np.bincount(labels[labels >= 0], minlength=1)
    true_counts = np.bincount(truth[truth >= 0], minlength=1)
    both = (labels >= 0) & (truth >= 0)
    keys, shared = np.unique(
        labels[both].astype(np.int64) * len(true_counts) + truth[both], return_counts=True
    )
    a, b = keys // len(true_counts), keys % len(true_counts)
    matched = shared / (found_counts[a] + true_counts[b] - shared) > 0.5
    outliers = truth < 0
    return Agreement(
        recall=float(matched.sum() / len(true_counts)),
        precision=float(matched.sum() / len(found_counts)),
        right=float(shared[matched].sum() / max(1, len(truth) - outliers.sum())),
        strays=float((labels[outliers] >= 0).sum() / max(1, outliers.sum())),
    )
