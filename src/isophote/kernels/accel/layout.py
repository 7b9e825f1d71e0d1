"""How trees lie in memory: one flat float32 array of nodes, one of leaf blocks.

A node has `WIDTH` children and fills `NODE` words: for each of x, y, z the lower bounds of all children, then
for each axis the upper bounds, then one int32 a child. Missing children have the box (+inf, -inf), which no ray
enters. The last words are free but for word `REACH` of a tree's root: the largest size of a coordinate in the tree, by
which rays are widened (spread.py). A child's code is

    code >= 0    the number of another node
    code <  0    a leaf: -1 - code = first * 8 + count, `count` (1 to 7) consecutive blocks from `first` on, or part
                 `first` of a tree that is not finished, where `count` is 0 (waiting.py)

A block holds `LANES` triangles and fills `BLOCK` words: x of the first corners of all lanes, y, z, the same for the
second and the third corners, then one int32 a lane, the triangle's number. Lanes without a triangle have NaN
corners, which no ray hits, and the number -1.
"""

from __future__ import annotations

WIDTH = 8
NODE = 64
LOWER = 0
UPPER = 24
CHILD = 48
REACH = 56

LANES = 4
BLOCK = 40
NUMBER = 36

MAX_BLOCKS = 7
MAX_DEPTH = 60

# Words of scratch that a traversal needs: two a stack entry, at most WIDTH - 1 entries a level, and one row of
# distances at the end, and one for what else is noted.
STACK = 2 * (WIDTH - 1) * (MAX_DEPTH + 4)
NOTED = STACK + WIDTH
SCRATCH = STACK + 2 * WIDTH

# Rays of a packet, and where its scratch lies: rows of origins, directions, limits, of what is found and of shears,
# one row of distances to children and of what else is noted, then the stack.
PACKET = 16
PACKET_NEAR = 13 * PACKET
PACKET_NOTED = PACKET_NEAR + WIDTH
PACKET_STACK = 14 * PACKET
PACKET_SCRATCH = PACKET_STACK + STACK
