"""A tree over many lights: one is picked by what it may send to a point, in a time that grows with the logarithm of
their number.

Bounds are those of Conty Estevez, Kulla: "Importance Sampling of Many Lights with Adaptive Tree Splitting", 2018: of
the places (here a ball), of the axes (a cone of half angle θ_o), and of the angle θ_e from its axis to which a light
shines. With θ from the axis to the point, θ_i from the point's normal to the ball's middle, and θ_u the half angle
under which the ball is seen, the lights below a node count

    I cosθ' cosθ'_i / max(d², r²),   θ' = max(θ − θ_o − θ_u, 0), 0 if θ' ≥ θ_e,   θ'_i = max(θ_i − θ_u, 0),

where I is the sum of their greatest radiant intensities. A node has eight children, all bounded at once, and a leaf is
one light. A child is picked by its share among the eight, so the chance of a light is a product over the way to it.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.doubles import doubles_at
from isophote.kernels.base.entry import element_address, entry, floats_at, opener_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.random import combine
from isophote.kernels.base.simd import (
    absolute,
    load8,
    load_int,
    maximum,
    minimum,
    select,
    splat8,
    square_root,
    store8,
)
from isophote.kernels.base.vec import dot, load_vec3
from isophote.kernels.light.light_tree_layout import (
    ASK_WORDS,
    AXIS,
    CHANCE,
    CHILDREN,
    INTENSITY,
    LANES,
    LIGHT_TREE,
    MIDDLE,
    NODE,
    NORMAL,
    NUMBER,
    OPENING,
    PLACE,
    RADIUS,
    REACH,
    SHARES,
    SUMS,
)

__all__ = ["ask_light_tree"]

_ZERO, _ONE = np.float32(0), np.float32(1)
_LEAST = np.float32(1e-30)
# Cosines count this much more, lest rounding takes what shines at a grazing angle for dark.
_SLACK = np.float32(2.0**-13)
_NODE, _LANES, _LANE = np.int64(NODE), np.int64(3), np.int64(7)
_FINEST = 2.0**-56
_ONE_BELOW = 1 - 2.0**-53
_ROOT, _NONE = np.int64(0), np.int64(-1)
_WORDS, _SUMS, _LANES_64 = np.int64(ASK_WORDS), np.int64(SUMS), np.int64(LANES)


@device
def _bound_children(nodes, at, ask):
    """Shares of the eight children of the node at word `at`, as seen from what is asked, into the scratch."""
    one, zero, slack = splat8(_ONE), splat8(_ZERO), splat8(_SLACK)
    x = load8(nodes, at + MIDDLE) - splat8(ask[PLACE])
    y = load8(nodes, at + MIDDLE + 8) - splat8(ask[PLACE + 1])
    z = load8(nodes, at + MIDDLE + 16) - splat8(ask[PLACE + 2])
    closeness = square_root(one / maximum(x * x + y * y + z * z, splat8(_LEAST)))
    # Sine of θ_u, above 1 within the ball. cos(θ − θ_u) ≤ cosθ + 2 sinθ_u, and both cos(θ − θ_u) and cosθ + sinθ_u
    # vanish where θ = π / 2 + θ_u.
    radius = load8(nodes, at + RADIUS)
    ball = radius * closeness + slack
    toward = load8(nodes, at + AXIS) * x + load8(nodes, at + AXIS + 8) * y + load8(nodes, at + AXIS + 16) * z
    cosine = zero - toward * closeness
    signed = load8(nodes, at + INTENSITY)
    cosine = select(signed < zero, absolute(cosine), cosine)
    sine = square_root(maximum(one - cosine * cosine, zero))
    opening = load8(nodes, at + OPENING)
    outside = cosine * opening + sine * square_root(maximum(one - opening * opening, zero))
    cosine = select(cosine < opening, outside, one) + ball
    within = load8(nodes, at + REACH) < cosine + ball
    share = select(within, maximum(minimum(cosine, one), zero), zero) * absolute(signed)
    near = minimum(closeness, one / radius)
    share = share * (near * near)
    normal = load_vec3(ask, NORMAL)
    if dot(normal, normal) > _ZERO:
        above = (splat8(normal.x) * x + splat8(normal.y) * y + splat8(normal.z) * z) * closeness + ball
        share = share * maximum(minimum(above, one), zero)
    store8(ask, SHARES, share)


@device
def _sums(ask):
    return doubles_at(element_address(ask, _SUMS), _LANES_64)


@device
def _add_up(ask):
    """Sums of the shares up to each, in double precision, so that those that hardly count count rightly; the whole."""
    sums = _sums(ask)
    for pair in range(0, LANES, 2):
        sums[pair] = np.float64(ask[SHARES + pair])
        sums[pair + 1] = sums[pair] + np.float64(ask[SHARES + pair + 1])
    for four in range(0, LANES, 4):
        sums[four + 2] += sums[four + 1]
        sums[four + 3] += sums[four + 1]
    for lane in range(4, LANES):
        sums[lane] += sums[3]
    return sums[7]


@device
def _choose(ask, wanted):
    """The share in which `wanted` falls, by the sums; counted, since a branch would be guessed wrong."""
    sums, lane = _sums(ask), np.int64(0)
    for k in range(LANES):
        lane += sums[k] <= wanted
    # Rounded up to the whole: the last share that counts.
    while lane > 0 and not ask[SHARES + min(lane, _LANE)] > _ZERO:
        lane -= 1
    return min(lane, _LANE)


@device
def _pick(tree, ask):
    """A light, or −1 where none can send any light to the place; its chance."""
    nodes, node, chance = tree.nodes, np.int64(0), 1.0
    sums = _sums(ask)
    # The number has 24 bits, some lights a smaller chance; what is below comes from the place.
    finer = combine(np.uint32(load_int(ask, PLACE)), np.uint32(load_int(ask, NUMBER)))
    u = np.float64(ask[NUMBER]) + np.float64(finer) * _FINEST
    while node >= 0:
        at = node * _NODE
        _bound_children(nodes, at, ask)
        total = _add_up(ask)
        if not total > 0.0:
            ask[CHANCE] = _ONE
            return _NONE
        lane = _choose(ask, u * total)
        share = np.float64(ask[SHARES + lane])
        chance *= share / total
        u = min(max((u * total - sums[lane]) / share + 1.0, 0.0), _ONE_BELOW)
        node = np.int64(load_int(nodes, at + CHILDREN + lane))
    ask[CHANCE] = np.float32(chance)
    return ~node


@device
def _chance_of(tree, ask, k):
    """Chance with which `_pick` finds light `k`, leaf to root."""
    hung, chance = np.int64(tree.leaves[k]), 1.0
    while hung >= 0:
        node, lane = hung >> _LANES, hung & _LANE
        _bound_children(tree.nodes, node * _NODE, ask)
        share = np.float64(ask[SHARES + lane])
        if not share > 0.0:
            ask[CHANCE] = _ZERO
            return k
        chance *= share / _add_up(ask)
        hung = np.int64(tree.parents[node])
    ask[CHANCE] = np.float32(chance)
    return k


_tree_at = opener_at(LIGHT_TREE)


@entry
def ask_light_tree(tree_words, ask_address, k):
    """Pick a light for what is asked if `k` is −1, or find the chance of light `k`; returns the light, −1 for none."""
    tree, ask = _tree_at(tree_words), floats_at(ask_address, _WORDS)
    return _pick(tree, ask) if k < 0 else _chance_of(tree, ask, k)
