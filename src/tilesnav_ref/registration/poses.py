"""Files of poses: a line a pose with time, place and unit quaternion, as the TUM RGB-D benchmark has them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tilesnav_ref.registration.settings import RegistrationError

HEADER = "# time x y z qx qy qz qw: seconds, metres, unit quaternion; map from scan\n"
FILE_BYTES = 1 << 24
"""Most bytes of a file of poses, about 200,000 lines."""
UNIT = 1e-3
"""Greatest difference of the length of a quaternion from 1; three decimals."""


def read_poses(path: Path) -> NDArray[np.float64]:
    """Read poses in the order of the lines; those that begin with # are remarks.

    Returns
    -------
    (S, 4, 4) float64

    Raises
    ------
    RegistrationError
        Naming the line that is no pose.
    """
    size = path.stat().st_size
    if size > FILE_BYTES:
        raise RegistrationError(str(path), f"{size} bytes", f"{FILE_BYTES} at most")
    poses = []
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    for number, line in enumerate(lines, start=1):
        if line.strip() and not line.lstrip().startswith("#"):
            poses.append(_pose(line, f"{path}, line {number}"))
    return np.array(poses).reshape(-1, 4, 4)


def _pose(line: str, where: str) -> NDArray[np.float64]:
    try:
        values = np.array([float(word) for word in line.split()])
    except ValueError:
        values = np.zeros(0)
    if len(values) != 8 or not np.isfinite(values).all():
        raise RegistrationError(where, repr(line[:80]), "eight numbers: time x y z qx qy qz qw")
    length = float(np.linalg.norm(values[4:]))
    if abs(length - 1.0) > UNIT:
        raise RegistrationError(where, f"a quaternion of length {length:g}", "length 1")
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_quat(values[4:]).as_matrix()
    pose[:3, 3] = values[1:4]
    return pose


def write_poses(path: Path, poses: NDArray[np.float64]) -> None:
    """Write poses (S, 4, 4); the time is the number of the scan."""
    quaternions = Rotation.from_matrix(poses[:, :3, :3]).as_quat(canonical=True)
    rows = np.concatenate((poses[:, :3, 3], quaternions), axis=1)
    lines = [f"{k} " + " ".join(f"{value:.9f}" for value in row) + "\n" for k, row in enumerate(rows)]
    path.write_text(HEADER + "".join(lines), encoding="ascii")
