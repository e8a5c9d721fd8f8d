"""The figures that evaluation_test.cpp expects, by other means than evaluation.cpp uses: general
optimisers for the alignments, general matrix logarithms for the twists, plain loops for the rest.

    /usr/bin/python3 src/chasles/eval/evaluation_oracle.py
"""

import numpy as np
from scipy.linalg import logm
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

N = 400
i = np.arange(N)
zero = 0 * i


def matrices(rotation_vectors):
    return Rotation.from_rotvec(rotation_vectors).as_matrix()


# Truth: test::helix(400). Estimate: drifting, as in evaluation_test.cpp.
a = 0.1 * i
R_true = matrices(np.c_[zero, zero, a + np.pi / 2]) @ matrices(
    np.c_[0.05 * np.sin(3 * a), zero + 0.1, zero])
p_true = np.c_[50 * np.cos(a), 50 * np.sin(a), 2 * a]
theta = 0.01 * np.c_[np.sin(0.2 * i), np.cos(0.13 * i), 0.002 * i]
R = matrices(-theta) @ R_true
p = 1.003 * p_true - np.c_[0.5 * np.sin(0.05 * i), 0.01 * i, 0.3 * np.cos(0.07 * i)]


def angle(M):
    return Rotation.from_matrix(M).magnitude()


def report(name, A, t, scale=1):
    e = np.linalg.norm(scale * p @ A.T + t - p_true, axis=1)
    attitude = np.degrees(angle(R_true @ (A @ R).transpose(0, 2, 1)))
    print(name, *(f'{x:.12g}' for x in (np.sqrt(np.mean(e**2)), e.mean(), np.median(e), e.max(),
                                        np.sqrt(np.mean(attitude**2)))), f'scale {scale:.12g}')


def fit(free):
    """free(x) -> rotation, translation, scale; minimises the squared position differences."""
    def residual(x):
        A, t, s = free(x)
        return (s * p @ A.T + t - p_true).ravel()
    x = least_squares(residual, np.zeros(7), xtol=1e-15, ftol=1e-15, gtol=1e-15).x
    return free(x)


def turn(v):
    return Rotation.from_rotvec(v).as_matrix()


report('SE(3)', *fit(lambda x: (turn(x[:3]), x[3:6], 1.0)))
report('Sim(3)', *fit(lambda x: (turn(x[:3]), x[3:6], 1 + x[6])))
report('position + yaw', *fit(lambda x: (turn([0, 0, x[2]]), x[3:6], 1.0)))
A = R_true[0] @ R[0].T
report('first pose', A, p_true[0] - A @ p[0])

s = np.r_[0, np.cumsum(np.linalg.norm(np.diff(p_true, axis=0), axis=1))]


def pose(R, p):
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = R, p
    return T


T_true = [pose(R_true[k], p_true[k]) for k in range(N)]
T = [pose(R[k], p[k]) for k in range(N)]


def relative(f, l):
    E = np.linalg.inv(np.linalg.inv(T[f]) @ T[l]) @ np.linalg.inv(T_true[f]) @ T_true[l]
    return np.linalg.norm(E[:3, 3]), np.degrees(angle(E[:3, :3]))


for length in (100, 800):
    errors = []
    for f in range(0, N, 10):
        later = np.nonzero(s > s[f] + length)[0]
        if len(later):
            errors.append(relative(f, later[0]))
    errors = np.array(errors) / length
    print('over', length, 'm:', f'{100 * errors[:, 0].mean():.12g} % {errors[:, 1].mean():.12g} deg/m',
          len(errors))
for seconds in (1, 10):
    errors = np.array([relative(f, f + 10 * seconds) for f in range(0, N - 10 * seconds, 10)])
    print('over', seconds, 's:', *(f'{x:.12g}' for x in errors.mean(0)), len(errors))


def twist(T):
    L = np.real(logm(T))
    return np.r_[L[2, 1], L[0, 2], L[1, 0], L[:3, 3]]


def hat(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


sigma = np.array([0.01, 0.02, 0.03, 0.5, 1, 2])
C = 0.7 * np.eye(6) + 0.3
world = T[0] @ np.linalg.inv(T_true[0])
for kind in ('standard', 'body', 'world'):
    values = []
    for k in range(1, N):
        X, X_hat, M = world @ T_true[k], T[k], np.eye(6)
        if kind == 'standard':
            e = np.r_[Rotation.from_matrix(X[:3, :3] @ R[k].T).as_rotvec(), X[:3, 3] - p[k]]
        elif kind == 'body':
            e = twist(np.linalg.inv(X_hat) @ X)
            M[:3, :3] = M[3:, 3:] = R[k].T
        else:
            e = twist(X @ np.linalg.inv(X_hat))
            M[3:, :3] = hat(p[k])
        d = np.diag(sigma * (1 + 0.001 * k))
        P = M @ d @ C @ d @ M.T
        values.append([e[b] @ np.linalg.inv(P[b, b]) @ e[b]
                       for b in (slice(3, 6), slice(0, 3), slice(0, 6))])
    print('NEES', kind, *(f'{x:.12g}' for x in np.mean(values, 0)))
