"""Connected pieces of a mesh, the sides that its faces can take, and its boundary loops."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device, kernel

__all__ = ["agree_on_sides", "join_vertices", "number_pieces", "repeats", "size_pieces", "trace_loops"]


@kernel
def repeats(indices, offsets, stamp, found):
    """Mark in `found`, (faces,), the faces that name a vertex twice; `stamp`, (vertices,) int32, is filled with -1.

    Faces are triangles where `offsets` is empty.
    """
    count = 0
    if len(offsets) == 0:
        for f in range(len(indices) // 3):
            a, b, c = indices[3 * f], indices[3 * f + 1], indices[3 * f + 2]
            found[f] = a == b or b == c or c == a
            count += found[f]
        return count
    for f in range(len(offsets) - 1):
        found[f] = False
        for k in range(offsets[f], offsets[f + 1]):
            found[f] |= stamp[indices[k]] == f
            stamp[indices[k]] = f
        count += found[f]
    return count


@device
def _root(parent, v):
    while parent[v] != v:
        parent[v] = parent[parent[v]]
        v = np.int64(parent[v])
    return v


@device
def _join(parent, a, b):
    a, b = _root(parent, a), _root(parent, b)
    if a < b:
        parent[b] = a
    elif b < a:
        parent[a] = b


@kernel
def join_vertices(indices, offsets, parent):
    """Unite the vertices of each face; `parent`, (vertices,), holds each vertex's own number before."""
    if len(offsets) == 0:
        for k in range(0, len(indices), 3):
            a = np.int64(indices[k])
            _join(parent, a, np.int64(indices[k + 1]))
            _join(parent, a, np.int64(indices[k + 2]))
        return
    for f in range(len(offsets) - 1):
        a = np.int64(indices[offsets[f]])
        for k in range(offsets[f] + 1, offsets[f + 1]):
            _join(parent, a, np.int64(indices[k]))


@kernel
def number_pieces(parent, degree):
    """Turn `parent` into numbers of pieces, by their least vertex, -1 for vertices without an edge: how many pieces."""
    count = np.int32(0)
    # Vertices hang below smaller ones, which have their number by now.
    for v in range(len(parent)):
        if degree[v] == 0:
            parent[v] = -1
        elif parent[v] == v:
            parent[v] = count
            count += 1
        else:
            parent[v] = parent[parent[v]]
    return count


@kernel
def size_pieces(piece, degree, indices, offsets, vertices, ends, faces):
    """Count for each piece its vertices, the ends of its edges and its faces."""
    for v in range(len(piece)):
        if piece[v] >= 0:
            vertices[piece[v]] += 1
            ends[piece[v]] += degree[v]
    if len(offsets) == 0:
        for k in range(0, len(indices), 3):
            faces[piece[indices[k]]] += 1
    for f in range(len(offsets) - 1):
        faces[piece[indices[offsets[f]]]] += 1


@kernel
def agree_on_sides(indices, face, offsets, twin, sheet, side, parent, queue, conflict):
    """Turn faces so that neighbours agree, sheet by sheet; a sheet is what is connected across edges of two faces.

    `sheet`, (faces,) filled with -1, gets each face's number of the sheet, `side` 1 where a face is to be turned,
    `parent` the half-edge by which it was reached, or -1. `conflict`, (faces,), gets for each sheet, in its first
    entry, a half-edge that its faces cannot agree on, or -1. Returns the number of sheets.
    """
    sheets = np.int32(0)
    for seed in range(len(sheet)):
        if sheet[seed] >= 0:
            continue
        sheet[seed], side[seed], parent[seed], conflict[sheets] = sheets, 0, -1, -1
        queue[0] = seed
        first, last = 0, 1
        while first < last:
            f = np.int64(queue[first])
            first += 1
            for h in range(offsets[f], offsets[f + 1]):
                t = np.int64(twin[h])
                if t < 0:
                    continue
                g = np.int64(face[t])
                wanted = side[f] ^ np.uint8(indices[h] == indices[t])
                if sheet[g] < 0:
                    sheet[g], side[g], parent[g] = sheets, wanted, h
                    queue[last] = g
                    last += 1
                elif side[g] != wanted and conflict[sheets] < 0:
                    conflict[sheets] = h
        sheets += 1
    return sheets


@kernel
def trace_loops(partner, crowded, order, starts, is_open):
    """Walk along edges without a neighbour, from end to end.

    Edge i has the ends 2 i and 2 i + 1; `partner` is the end that each one meets. `crowded` marks edges of three or
    more faces: they are not walked, and a chain stops at them. `order` gets the ends at which edges are entered, chain
    after chain; `starts` where each begins; `is_open` whether it is open. Chains come by the first edge's number,
    open ones first. Returns how many there are.
    """
    seen = crowded.copy()
    chains = 0
    length = 0
    for closed in range(2):
        for end in range(len(partner)):
            begins = closed == 1 or crowded[partner[end] >> 1]
            if seen[end >> 1] or not begins:
                continue
            starts[chains] = length
            is_open[chains] = closed == 0
            at = end
            while not seen[at >> 1]:
                seen[at >> 1] = True
                order[length] = at
                length += 1
                at = np.int64(partner[at ^ 1])
            chains += 1
    starts[chains] = length
    return chains
