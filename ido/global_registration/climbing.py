"""Expectation maximisation: from many starts uphill on the likelihood of a scene (docs/global.md, Eq. 4 and 5)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ido.compiling import compiled
from ido.global_registration.fields import REACH, Field
from ido.global_registration.outliers import Background
from ido.global_registration.parts import in_parts
from ido.types import DoubleArray, FloatArray

_OVER = 1.5  # steps are made longer by this factor
_MODEL_SHARE, _BALL_SHARE = 0.4, 0.2  # before the first step


@dataclass(frozen=True, slots=True, eq=False)
class Climb:
    """What many starts did at one width of the Gaussians.

    Args:
        sigma: the width, model units.
        poses: T_model_scene before the first step and after each, shape (n, steps + 1, 4, 4).
        shares: of the model and of the ball after the last step, shape (n, 2).
        log_likelihood: per scene point, before each step and after the last, shape (n, steps + 1).
    """

    sigma: float
    poses: DoubleArray
    shares: DoubleArray
    log_likelihood: DoubleArray

    @property
    def steps(self) -> int:
        return self.log_likelihood.shape[1] - 1


def climb(points: FloatArray, background: Background, field: Field, T: DoubleArray, steps: int) -> Climb:
    """Climb from poses T (n, 4, 4) by so many steps on one field, for points (S, 3); docs/global.md, Eq. 4 and 5."""
    points = np.ascontiguousarray(points, dtype=np.float32)
    track = np.tile(np.eye(4), (len(T), steps + 1, 1, 1))
    track[:, 0] = T
    shares = np.tile([_MODEL_SHARE, _BALL_SHARE if background.has_ball else 0.0], (len(T), 1))
    log_likelihood = np.empty((len(T), steps + 1))

    def part(begin: int, end: int) -> None:
        climb_all(
            points,
            background.ball,
            background.uniform,
            field.density,
            np.array([REACH, field.step, field.sigma**2, _OVER]),
            track[begin:end],
            shares[begin:end],
            log_likelihood[begin:end],
        )

    in_parts(len(T), part)
    return Climb(field.sigma, track, shares, log_likelihood / len(points))


@compiled(fastmath=True, error_model="numpy")
def climb_all(
    points: FloatArray,
    ball: FloatArray,
    uniform: float,
    density: FloatArray,
    numbers: DoubleArray,
    track: DoubleArray,
    shares: DoubleArray,
    log_likelihood: DoubleArray,
) -> None:
    """What `climb` does (docs/global.md, Eq. 4 and 5), compiled: fills `track`, `shares` and `log_likelihood`.

    `numbers` are reach, step, σ² and the factor of a step.
    """
    reach, step, sigma2, over = numbers
    n, last = density.shape[0], track.shape[1] - 1
    inverse = np.float32(1 / step)
    offset = np.float32(reach / step)
    highest = np.float32(n - 1)
    for b in range(len(track)):
        model_share, ball_share = shares[b, 0], shares[b, 1]
        for k in range(last + 1):
            T = track[b, k]
            r00, r01, r02, t0 = np.float32(T[0, 0]), np.float32(T[0, 1]), np.float32(T[0, 2]), np.float32(T[0, 3])
            r10, r11, r12, t1 = np.float32(T[1, 0]), np.float32(T[1, 1]), np.float32(T[1, 2]), np.float32(T[1, 3])
            r20, r21, r22, t2 = np.float32(T[2, 0]), np.float32(T[2, 1]), np.float32(T[2, 2]), np.float32(T[2, 3])
            pi, beta = np.float32(model_share), np.float32(ball_share)
            nu = np.float32((1 - model_share - ball_share) * uniform)
            pull = np.float32(sigma2 / step)
            weight = in_ball = logs = 0.0
            product = 1.0
            sx = sy = sz = xx = xy = xz = yy = yz = zz = 0.0
            vx = vy = vz = wx = wy = wz = 0.0
            for s in range(len(points)):
                a, d, c = points[s, 0], points[s, 1], points[s, 2]
                x = r00 * a + r01 * d + r02 * c + t0
                y = r10 * a + r11 * d + r12 * c + t1
                z = r20 * a + r21 * d + r22 * c + t2
                of_ball = beta * ball[s]
                total = nu + of_ball
                gx, gy, gz = x * inverse + offset, y * inverse + offset, z * inverse + offset
                if gx >= 0 and gy >= 0 and gz >= 0 and gx < highest and gy < highest and gz < highest:
                    i, j, h = int(gx), int(gy), int(gz)
                    fx, fy, fz = gx - np.float32(i), gy - np.float32(j), gz - np.float32(h)
                    p000, p001 = density[i, j, h], density[i, j, h + 1]
                    p010, p011 = density[i, j + 1, h], density[i, j + 1, h + 1]
                    p100, p101 = density[i + 1, j, h], density[i + 1, j, h + 1]
                    p110, p111 = density[i + 1, j + 1, h], density[i + 1, j + 1, h + 1]
                    d00, d01, d10, d11 = p001 - p000, p011 - p010, p101 - p100, p111 - p110
                    q00, q01, q10, q11 = p000 + fz * d00, p010 + fz * d01, p100 + fz * d10, p110 + fz * d11
                    e0, e1 = q01 - q00, q11 - q10
                    q0, q1 = q00 + fy * e0, q10 + fy * e1
                    p = pi * (q0 + fx * (q1 - q0))
                    if p > np.float32(1e-12):
                        total += p
                        g0 = d00 + fy * (d01 - d00)
                        g1 = d10 + fy * (d11 - d10)
                        scale = pi * pull / total
                        ux = scale * (q1 - q0)
                        uy = scale * (e0 + fx * (e1 - e0))
                        uz = scale * (g0 + fx * (g1 - g0))
                        r = p / total
                        weight += r
                        rx, ry, rz = r * x, r * y, r * z
                        sx += rx
                        sy += ry
                        sz += rz
                        xx += rx * x
                        xy += rx * y
                        xz += rx * z
                        yy += ry * y
                        yz += ry * z
                        zz += rz * z
                        vx += ux
                        vy += uy
                        vz += uz
                        wx += y * uz - z * uy
                        wy += z * ux - x * uz
                        wz += x * uy - y * ux
                in_ball += of_ball / total
                product *= total + 1e-12
                if s % 16 == 15:  # one logarithm for many
                    logs += np.log(product)
                    product = 1.0
            log_likelihood[b, k] = logs + np.log(product)
            if k == last:
                break
            model_share = min(max(weight / len(points), 0.02), 0.98)
            ball_share = min(in_ball / len(points), 0.99 - model_share)
            for row in range(3):
                for column in range(4):
                    track[b, k + 1, row, column] = T[row, column]
            if weight < 3:
                continue  # too little to climb on
            cx, cy, cz = sx / weight, sy / weight, sz / weight
            xx, xy, xz = xx - weight * cx * cx, xy - weight * cx * cy, xz - weight * cx * cz
            yy, yz, zz = yy - weight * cy * cy, yz - weight * cy * cz, zz - weight * cz * cz
            wx, wy, wz = wx - (cy * vz - cz * vy), wy - (cz * vx - cx * vz), wz - (cx * vy - cy * vx)
            # the inertia of the weighted points about their middle, symmetric, and its inverse by cofactors
            small = 1e-6 * (xx + yy + zz)
            ia, ib, ic = yy + zz + small, xx + zz + small, xx + yy + small
            m00, m01, m02 = ib * ic - yz * yz, xz * yz + xy * ic, xy * yz + xz * ib
            m11, m12, m22 = ia * ic - xz * xz, yz * ia + xy * xz, ia * ib - xy * xy
            determinant = ia * m00 - xy * m01 - xz * m02
            ox = over * (m00 * wx + m01 * wy + m02 * wz) / determinant
            oy = over * (m01 * wx + m11 * wy + m12 * wz) / determinant
            oz = over * (m02 * wx + m12 * wy + m22 * wz) / determinant
            turn(track[b, k + 1], ox, oy, oz, cx, cy, cz)
            track[b, k + 1, 0, 3] += over * vx / weight
            track[b, k + 1, 1, 3] += over * vy / weight
            track[b, k + 1, 2, 3] += over * vz / weight
        shares[b, 0], shares[b, 1] = model_share, ball_share


@compiled(error_model="numpy")
def turn(T: DoubleArray, ox: float, oy: float, oz: float, cx: float, cy: float, cz: float) -> None:
    """Turn a pose (4, 4) in place by the rotation vector o (at most 0.6 rad) about the point c."""
    angle = np.sqrt(ox * ox + oy * oy + oz * oz)
    if angle < 1e-12:
        return
    half = min(angle, 0.6) / 2
    w, s = np.cos(half), np.sin(half) / angle
    x, y, z = s * ox, s * oy, s * oz
    R = np.empty((3, 3))
    R[0, 0], R[0, 1], R[0, 2] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
    R[1, 0], R[1, 1], R[1, 2] = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
    R[2, 0], R[2, 1], R[2, 2] = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
    T[0, 3] -= cx
    T[1, 3] -= cy
    T[2, 3] -= cz
    for column in range(4):
        a, b, c = T[0, column], T[1, column], T[2, column]
        for row in range(3):
            T[row, column] = R[row, 0] * a + R[row, 1] * b + R[row, 2] * c
    T[0, 3] += cx
    T[1, 3] += cy
    T[2, 3] += cz
