"""Bundle adjustment of the tracks of one camera, for studies/track_walk.py: the pose of every frame, the points and
the lens are free, so that what remains are the errors of the tracks. Points are eliminated. Needs NumPy."""

import dataclasses

import numpy as np

from studies.arrays import Array

LENS = 8  # fx fy cx cy k1 k2 p1 p2


@dataclasses.dataclass
class Tracks:
    """Observations in the order of track and frame: the numbers of track and frame (both from 0 on), and pixels."""
    track: Array
    frame: Array
    pixel: Array

    def of(self, keep: Array) -> "Tracks":
        """The observations of some tracks (a mask by number), which are numbered anew."""
        kept = keep[self.track]
        number = np.cumsum(keep) - 1
        return Tracks(number[self.track[kept]], self.frame[kept], self.pixel[kept])

    def starts(self) -> Array:
        """The first observation of each track, and the end of the last."""
        return np.searchsorted(self.track, np.arange(self.track[-1] + 2))


@dataclasses.dataclass
class View:
    """Rotations world_R_camera and positions of the camera by frame, points by track, and the lens."""
    R: Array
    p: Array
    points: Array
    lens: Array


def skew(v: Array) -> Array:
    out = np.zeros((*v.shape[:-1], 3, 3))
    out[..., 0, 1], out[..., 0, 2], out[..., 1, 2] = -v[..., 2], v[..., 1], -v[..., 0]
    return out - np.swapaxes(out, -1, -2)


def turn(w: Array) -> Array:
    """The rotation matrices of rotation vectors."""
    angle = np.maximum(np.linalg.norm(w, axis=-1), 1e-12)[..., None, None]
    K = skew(w) / angle
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def distort(x: Array, y: Array, lens: Array) -> tuple[Array, Array]:
    """Normalised coordinates through the radial-tangential lens."""
    k1, k2, p1, p2 = lens[4:]
    r2 = x * x + y * y
    radial = 1 + k1 * r2 + k2 * r2 * r2
    return (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
            y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y)


def project(points: Array, lens: Array) -> tuple[Array, Array, Array]:
    """Pixels of points in the camera, and their derivatives by point and lens."""
    iz = 1 / points[:, 2]
    x, y = points[:, 0] * iz, points[:, 1] * iz
    xd, yd = distort(x, y, lens)
    pixel = np.stack([lens[0] * xd + lens[2], lens[1] * yd + lens[3]], 1)
    k1, k2, p1, p2 = lens[4:]
    r2 = x * x + y * y
    radial, slope = 1 + k1 * r2 + k2 * r2 * r2, k1 + 2 * k2 * r2
    xx = lens[0] * (radial + 2 * x * x * slope + 2 * p1 * y + 6 * p2 * x)
    yy = lens[1] * (radial + 2 * y * y * slope + 6 * p1 * y + 2 * p2 * x)
    mixed = 2 * x * y * slope + 2 * p1 * x + 2 * p2 * y
    xy, yx = lens[0] * mixed, lens[1] * mixed
    by_point = np.stack([np.stack([xx * iz, xy * iz, -(xx * x + xy * y) * iz], 1),
                         np.stack([yx * iz, yy * iz, -(yx * x + yy * y) * iz], 1)], 1)
    o, one = np.zeros_like(x), np.ones_like(x)
    by_lens = np.stack([
        np.stack([xd, o, one, o, *(lens[0] * d for d in (x * r2, x * r2 * r2, 2 * x * y, r2 + 2 * x * x))], 1),
        np.stack([o, yd, o, one, *(lens[1] * d for d in (y * r2, y * r2 * r2, r2 + 2 * y * y, 2 * x * y))], 1)], 1)
    return pixel, by_point, by_lens


def rays(pixel: Array, lens: Array) -> Array:
    """Unit rays in the camera, by fixed-point iterations of the lens."""
    wanted = (pixel - lens[2:4]) / lens[:2]
    xy = wanted.copy()
    for _ in range(30):
        xy += wanted - np.stack(distort(xy[:, 0], xy[:, 1], lens), 1)
    ray = np.column_stack([xy, np.ones(len(xy))])
    return ray / np.linalg.norm(ray, axis=1, keepdims=True)


def triangulate(tracks: Tracks, view: View) -> Array:
    """The points nearest to the rays of each track."""
    ray = np.einsum("nij,nj->ni", view.R[tracks.frame], rays(tracks.pixel, view.lens))
    across = np.eye(3) - ray[:, :, None] * ray[:, None, :]
    at = tracks.starts()[:-1]
    H = np.add.reduceat(across, at) + 1e-9 * np.eye(3)
    return np.linalg.solve(H, np.add.reduceat(across @ view.p[tracks.frame][:, :, None], at))[:, :, 0]


def seen(tracks: Tracks, view: View) -> Array:
    """The point of each observation in its camera."""
    offset = view.points[tracks.track] - view.p[tracks.frame]
    return np.einsum("nji,nj->ni", view.R[tracks.frame], offset)


def depths(tracks: Tracks, view: View) -> Array:
    return seen(tracks, view)[:, 2]


def parallaxes(tracks: Tracks, view: View) -> Array:
    """Twice the largest angle between a track's rays and their mean [rad]."""
    ray = view.points[tracks.track] - view.p[tracks.frame]
    ray /= np.linalg.norm(ray, axis=1, keepdims=True)
    at = tracks.starts()[:-1]
    mean = np.add.reduceat(ray, at)
    mean /= np.linalg.norm(mean, axis=1, keepdims=True)
    cosine = np.clip(np.sum(ray * mean[tracks.track], axis=1), -1, 1)
    return 2 * np.maximum.reduceat(np.arccos(cosine), at)


def residuals(tracks: Tracks, view: View) -> tuple[Array, Array, Array, Array]:
    """Observed minus expected pixels, and the derivatives of the latter by pose, lens and point."""
    camera = seen(tracks, view)
    camera[:, 2] = np.maximum(camera[:, 2], 0.05)
    pixel, by_camera, by_lens = project(camera, view.lens)
    by_point = by_camera @ np.swapaxes(view.R[tracks.frame], 1, 2)
    by_pose = np.concatenate([by_camera @ skew(camera), -by_point], 2)
    return tracks.pixel - pixel, by_pose, by_lens, by_point


def track_system(frames: Array, by_pose: Array, by_lens: Array, count: int) -> tuple[Array, Array]:
    """The unknowns that a track's observations depend on, besides its point, and the dense derivative."""
    n = len(frames)
    J = np.zeros((n, 2, 6 * n + LENS))
    for i in range(n):
        J[i, :, 6 * i:6 * i + 6] = by_pose[i]
    J[:, :, 6 * n:] = by_lens
    return np.r_[(6 * frames[:, None] + np.arange(6)).reshape(-1), 6 * count + np.arange(LENS)], J


def whitened(factor: Array, of: Array) -> Array:
    """n x 2 x m derivatives or n x 2 errors of a track as 2n rows, times the inverse of the factor on either axis."""
    return np.linalg.solve(factor, of.reshape(len(factor), -1)).reshape(2 * len(factor), -1)


def adjust(tracks: Tracks, view: View, steps: int, factors: list[Array], free: bool) -> View:
    """Gauss-Newton steps. `factors`: of the covariance of each track's errors along an image axis [px], lower
    triangle. `free`: poses and lens are, and a weak prior holds the poses where they began (0.02 rad, 0.1 m)."""
    frames = len(view.R)
    prior = np.r_[np.tile(np.repeat([1 / 0.02, 1 / 0.1], 3) ** 2, frames), np.full(LENS, 1e-9)]
    moved = np.zeros(6 * frames + LENS)
    starts = tracks.starts()
    for _ in range(steps):
        r, by_pose, by_lens, by_point = residuals(tracks, view)
        H, g = np.diag(prior), -prior * moved
        systems = []
        for factor, begin, end in zip(factors, starts, starts[1:]):
            at, J = track_system(tracks.frame[begin:end], by_pose[begin:end], by_lens[begin:end], frames)
            J, e, P = (whitened(factor, of) for of in (J, r[begin:end], by_point[begin:end]))
            systems.append((at, J, e, P))
            if free:
                Q, _ = np.linalg.qr(P)
                N = J - Q @ (Q.T @ J)
                H[np.ix_(at, at)] += N.T @ N
                g[at] += N.T @ e[:, 0]
        x = np.linalg.solve(H, g) if free else np.zeros(len(H))
        moved += x
        step = x[:6 * frames].reshape(-1, 6)
        move = np.array([np.linalg.lstsq(P, e[:, 0] - J @ x[at], rcond=None)[0] for at, J, e, P in systems])
        move *= np.minimum(1, 2 / np.maximum(np.linalg.norm(move, axis=1), 1e-9))[:, None]  # [m]
        view = View(view.R @ turn(step[:, :3]), view.p + step[:, 3:], view.points + move,
                    view.lens + x[6 * frames:])
    return view
