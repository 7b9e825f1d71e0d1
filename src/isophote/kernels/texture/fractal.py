"""Sums of noise at finer and finer scales. Source: Musgrave, in Ebert et al., "Texturing and Modeling", 2003."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.entry import entry
from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import load_vec3, store_vec3, vec3
from isophote.kernels.texture.combine import child
from isophote.kernels.texture.contract import CHILD_A, OWN, OWN_A, OWN_B, open_place
from isophote.kernels.texture.lattice import answer_number, datum, fade, footprint

__all__ = ["FBM", "RIDGED", "TURBULENCE", "fractal"]

FBM, TURBULENCE, RIDGED = 0, 1, 2

_OCTAVES, _GAIN, _LACUNARITY, _KIND, _SIZE, _MEAN, _REACH = (np.int64(k) for k in range(7))
_ZERO, _HALF, _ONE, _TWO = np.float32(0), np.float32(0.5), np.float32(1), np.float32(2)
# Each octave begins elsewhere, so that their lattices do not meet at the origin.
_OFFSET = (np.float32(19.1875), np.float32(7.3125), np.float32(31.6875))


@device
def _term(kind, number):
    """What an octave adds, of a noise from 0 to 1."""
    signed = _TWO * number - _ONE
    if kind == FBM:
        return signed
    if kind == TURBULENCE:
        return abs(signed)
    return (_ONE - abs(signed)) * (_ONE - abs(signed))


@entry
def fractal(textures, node, record_address):
    """Data: octaves, gain, lacunarity, kind, size of the child's cells, mean of an octave, reach."""
    place = open_place(textures, node, record_address)
    record = place.record
    p, a, b = load_vec3(record, OWN), load_vec3(record, OWN_A), load_vec3(record, OWN_B)
    kind, mean = np.int64(datum(place, _KIND)), datum(place, _MEAN)
    gain, lacunarity = datum(place, _GAIN), datum(place, _LACUNARITY)
    size, reach = datum(place, _SIZE), datum(place, _REACH)
    width = footprint(place) / size
    offset = vec3(_OFFSET[0], _OFFSET[1], _OFFSET[2]) * size
    nothing = vec3(_ZERO, _ZERO, _ZERO)
    store_vec3(record, OWN_A, nothing)
    store_vec3(record, OWN_B, nothing)
    total, whole, amplitude, weight, scale = _ZERO, _ZERO, _ONE, _ONE, _ONE
    for octave in range(np.int64(datum(place, _OCTAVES))):
        seen = fade(width * scale, reach)
        term = mean
        if seen > _ZERO:
            store_vec3(record, OWN, p * scale + offset * np.float32(octave))
            number, _ = child(place, CHILD_A)
            term += (_term(kind, number.x) - mean) * seen
        if kind == RIDGED:
            term *= weight
            weight = min(_TWO * term, _ONE)
        total += amplitude * term
        whole += amplitude
        amplitude *= gain
        scale *= lacunarity
    store_vec3(record, OWN, p)
    store_vec3(record, OWN_A, a)
    store_vec3(record, OWN_B, b)
    result = total / whole
    return answer_number(place, _HALF + _HALF * result if kind == FBM else result)
