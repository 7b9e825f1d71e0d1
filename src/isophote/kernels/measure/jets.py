"""Surfaces near a vertex as polynomials of height over the tangent plane, fitted to the vertices around it.

h(u, v) = Σ c_ij u^i v^j for 1 ≤ i + j ≤ degree: the surface goes through the vertex itself. Least squares over the
vertices within some rings. Curvatures of a fit of degree d have an error of order d − 1 in the size of the triangles,
whatever their shapes. Source: Cazals, Pouget, "Estimating Differential Quantities Using Polynomial Fitting of
Osculating Jets", 2005.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.double3 import Double3, cross3, difference, dot3, norm, row3, scaled, total
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.simd_double import load_doubles, splat_doubles, store_doubles

__all__ = ["MOST_NEIGHBOURS", "SCRATCH", "TERMS", "fit_vertices"]

# Vertices that a fit takes at most, its coefficients at degree 4, and the doubles of scratch that a thread needs.
MOST_NEIGHBOURS = 160
TERMS = 14
# A row of the fit's matrices: the terms, the height behind them, and up to two vectors what does not matter.
_WIDTH, _LANES = np.int64(16), np.int64(8)
_SAMPLES = np.int64(0)
_MATRIX = _SAMPLES + MOST_NEIGHBOURS * _WIDTH
_FOUND = _MATRIX + TERMS * _WIDTH
SCRATCH = int(_FOUND + _WIDTH)
_MOST = np.uint64(MOST_NEIGHBOURS + 1)
# A pivot below this part of its column means that the vertices don't determine a coefficient.
_SINGULAR = 1e-10


@device
def _terms(degree):
    """Coefficients of a polynomial of two variables without its constant."""
    return (degree + 1) * (degree + 2) // 2 - 1


@device
def _gather(starts, neighbours, v, rings, wanted, mark, found):
    """The vertices within `rings` edges of v, and of further rings until there are `wanted`, behind v itself.

    They come to `found`; returns how many. `mark` (n,) int32 holds no number v when called.
    """
    mark[v] = v
    found[0] = v
    count, head, ring = np.uint64(1), np.uint64(0), 0
    while True:
        tail = count
        while head < tail:
            at = np.uint64(found[head])
            head += np.uint64(1)
            for k in range(starts[at], starts[at + np.uint64(1)]):
                w = np.uint64(neighbours[np.uint64(k)])
                if mark[w] != v and count < _MOST:
                    mark[w] = v
                    found[count] = w
                    count += np.uint64(1)
        ring += 1
        if count in (tail, _MOST) or (ring >= rings and count > wanted):
            return np.int64(count) - 1


@device
def _place(positions, v, normal, found, count, scratch):
    """Coordinates of the neighbours in a frame at v, (u, v, height), at the head of their rows of samples. Returns the
    frame's axes in the tangent plane, and the size of it all."""
    a = Double3(1.0, 0.0, 0.0) if abs(normal.x) < 0.6 else Double3(0.0, 1.0, 0.0)
    e1 = cross3(normal, a)
    e1 = scaled(e1, 1.0 / norm(e1))
    e2 = cross3(normal, e1)
    p = row3(positions, v)
    size = 0.0
    for k in range(count):
        w = found[k + 1]
        d = difference(row3(positions, w), p)
        x, y = dot3(d, e1), dot3(d, e2)
        at = k * _WIDTH
        scratch[at], scratch[at + 1], scratch[at + 2] = x, y, dot3(d, normal)
        size = max(size, x * x + y * y)
    return e1, e2, math.sqrt(size)


@device
def _expand(scratch, count, degree, size):
    """Turn coordinates into rows of samples: the terms of a polynomial in (u, v) / size, and height / size."""
    inverse = 1.0 / size
    for row in range(0, count * _WIDTH, _WIDTH):
        x, y, h = scratch[row] * inverse, scratch[row + 1] * inverse, scratch[row + 2] * inverse
        xx, xy, yy = x * x, x * y, y * y
        scratch[row], scratch[row + 1] = x, y
        scratch[row + 2], scratch[row + 3], scratch[row + 4] = xx, xy, yy
        at = row + 5
        if degree > 2:
            scratch[at], scratch[at + 1], scratch[at + 2], scratch[at + 3] = xx * x, xx * y, x * yy, yy * y
            at += 4
        if degree > 3:
            scratch[at], scratch[at + 1], scratch[at + 2] = xx * xx, xx * xy, xx * yy
            scratch[at + 3], scratch[at + 4] = xy * yy, yy * yy
            at += 5
        scratch[at] = h


@device
def _accumulate(scratch, count, terms):
    """Normal equations: sums of products of each term with all that stand behind it."""
    end = count * _WIDTH
    for part in range(0, terms + 1, _LANES):
        # Five rows at a time, so that no sum waits for another. Behind the diagonal nothing is needed.
        for i in range(0, min(terms, part + _LANES), 5):
            a, b, c = splat_doubles(0.0), splat_doubles(0.0), splat_doubles(0.0)
            d, e = splat_doubles(0.0), splat_doubles(0.0)
            for row in range(0, end, _WIDTH):
                line = load_doubles(scratch, row + part)
                a = a + splat_doubles(scratch[row + i]) * line
                b = b + splat_doubles(scratch[row + i + 1]) * line
                c = c + splat_doubles(scratch[row + i + 2]) * line
                d = d + splat_doubles(scratch[row + i + 3]) * line
                e = e + splat_doubles(scratch[row + i + 4]) * line
            at = _MATRIX + i * _WIDTH + part
            store_doubles(scratch, at, a)
            store_doubles(scratch, at + _WIDTH, b)
            store_doubles(scratch, at + 2 * _WIDTH, c)
            store_doubles(scratch, at + 3 * _WIDTH, d)
            if i + 4 < terms:
                store_doubles(scratch, at + 4 * _WIDTH, e)


@device
def _solve(scratch, terms):
    """Solve the normal equations in place (LDLᵀ), the coefficients to _FOUND. Returns whether they are determined.

    _FOUND holds the diagonal as it was before elimination, then the pivots' inverses, then the coefficients.
    """
    for k in range(terms):
        row = _MATRIX + k * _WIDTH
        pivot = scratch[row + k]
        if not pivot > _SINGULAR * scratch[_FOUND + k]:
            return False
        inverse = 1.0 / pivot
        for i in range(k + 1, terms):
            factor = splat_doubles(scratch[row + i] * inverse)
            other = _MATRIX + i * _WIDTH
            for part in range(0, terms + 1, _LANES):
                line = load_doubles(scratch, other + part) - factor * load_doubles(scratch, row + part)
                store_doubles(scratch, other + part, line)
        scratch[_FOUND + k] = inverse
    for i in range(terms - 1, -1, -1):
        row = _MATRIX + i * _WIDTH
        value = scratch[row + terms]
        for j in range(i + 1, terms):
            value -= scratch[row + j] * scratch[_FOUND + j]
        scratch[_FOUND + i] *= value
    return True


@device
def _fit(scratch, count, degree, size, positions, v, normal, found):
    """Fit the highest degree up to `degree` that the neighbours determine. Returns it, or 0."""
    wanted = degree
    while degree > 1:
        terms = _terms(degree)
        if count >= terms:
            if degree < wanted:
                _place(positions, v, normal, found, count, scratch)
            _expand(scratch, count, degree, size)
            _accumulate(scratch, count, terms)
            for i in range(terms):
                scratch[_FOUND + i] = scratch[_MATRIX + i * _WIDTH + i]
            if _solve(scratch, terms):
                return degree
        degree -= 1
    return np.int64(0)


@device
def _eigen(a, b, c):
    """Eigenvalues k1 ≥ k2 of the symmetric matrix ((a, b), (b, c)), and the direction of the first."""
    mean, half = 0.5 * (a + c), 0.5 * (a - c)
    radius = math.sqrt(half * half + b * b)
    # The direction has half the angle of (half, b).
    if radius == 0.0:
        return mean, mean, 1.0, 0.0
    if half >= 0.0:
        x = math.sqrt(0.5 * (radius + half) / radius)
        return mean + radius, mean - radius, x, 0.5 * b / (radius * x)
    y = math.copysign(math.sqrt(0.5 * (radius - half) / radius), b)
    return mean + radius, mean - radius, 0.5 * b / (radius * y), y


@device
def _write_direction(out, v, d):
    d = scaled(d, 1.0 / norm(d))
    out[v, 0], out[v, 1], out[v, 2] = d.x, d.y, d.z


@kernel
def fit_vertices(
    positions,
    starts,
    neighbours,
    normals,
    degree,
    rings,
    first,
    last,
    mark,
    found,
    scratch,
    values,
    first_axes,
    second_axes,
    fitted,
    degrees,
):
    """Fit at vertices `first` ≤ v < `last`. `values` (n, 2) gets k1 ≥ k2, positive where the surface bends toward its
    normal's other side, as a sphere's does; the axes (n, 3) their directions; `fitted` (n, 3) the fit's normal;
    `degrees` (n,) the degree that the neighbours determined, 0 for none (values are NaN then)."""
    for v in range(first, last):
        normal = row3(normals, v)
        used = np.int64(0)
        if norm(normal) > 0.5:
            count = _gather(starts, neighbours, v, rings, _terms(degree) + 3, mark, found)
            e1, e2, size = _place(positions, v, normal, found, count, scratch)
            if size > 0.0:
                used = _fit(scratch, count, degree, size, positions, v, normal, found)
        degrees[v] = used
        if used == 0:
            values[v, 0] = values[v, 1] = np.nan
            for axis in range(3):
                first_axes[v, axis] = second_axes[v, axis] = 0.0
                fitted[v, axis] = normals[v, axis]
            continue
        p, q = scratch[_FOUND], scratch[_FOUND + 1]
        r, s, t = 2.0 * scratch[_FOUND + 2] / size, scratch[_FOUND + 3] / size, 2.0 * scratch[_FOUND + 4] / size
        # An orthonormal frame of the fit's tangent plane: along the steepest slope, and across it.
        slope = math.sqrt(p * p + q * q)
        cu, su = (p / slope, q / slope) if slope > 0.0 else (1.0, 0.0)
        w = math.sqrt(1.0 + slope * slope)
        # Second derivatives along (cu, su) / w and (−su, cu), over w: the second fundamental form, negated.
        a = -(r * cu * cu + 2.0 * s * cu * su + t * su * su) / (w * w * w)
        b = -((t - r) * cu * su + s * (cu * cu - su * su)) / (w * w)
        c = -(r * su * su - 2.0 * s * cu * su + t * cu * cu) / w
        k1, k2, x, y = _eigen(a, b, c)
        steepest = total(scaled(e1, cu), scaled(e2, su))
        along = scaled(total(steepest, scaled(normal, slope)), 1.0 / w)
        across = difference(scaled(e2, cu), scaled(e1, su))
        values[v, 0], values[v, 1] = k1, k2
        _write_direction(first_axes, v, total(scaled(along, x), scaled(across, y)))
        _write_direction(second_axes, v, difference(scaled(across, x), scaled(along, y)))
        _write_direction(fitted, v, difference(normal, scaled(steepest, slope)))
