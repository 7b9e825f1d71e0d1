"""Numbers of the operators of a field's tape, and the words of one of its rows.

Plain numbers, without Numba, so that the operator table of fields can name them without loading what runs them.
"""

from __future__ import annotations

# Words of a row: operator, the slot that it writes, the slots that it reads (0 where it reads fewer than three), its
# constant (the bits of a float32, or the number of a table), and, as the bits of float32 too, the Lipschitz constant of
# its value and how far rounding can put values apart that the constant holds together.
OP, OUT, A, B, C, IMM, LIPSCHITZ, ROUNDING, ROW = 0, 1, 2, 3, 4, 5, 6, 7, 8

# The interpreters, of which each has functions of its own for tables.
VALUES, INTERVALS, GRADIENTS = 0, 1, 2

# Slots 0, 1, 2 hold the point; the first row writes slot 3.
INPUTS = 3

CONSTANT = 0
COPY = 1
NEGATE = 2
ABSOLUTE = 3
SQUARE = 4
SQUARE_ROOT = 5
SINE = 6
COSINE = 7
ARC_SINE = 8
ARC_COSINE = 9
EXPONENTIAL = 10
LOGARITHM = 11
FLOOR = 12
ROUND = 13
ADD = 14
SUBTRACT = 15
MULTIPLY = 16
DIVIDE = 17
MINIMUM = 18
MAXIMUM = 19
LENGTH2 = 20
ARC_TANGENT = 21
ADD_CONSTANT = 22
MULTIPLY_CONSTANT = 23
CONSTANT_MINUS = 24
CONSTANT_OVER = 25
MINIMUM_CONSTANT = 26
MAXIMUM_CONSTANT = 27
SMOOTH_MINIMUM = 28
SMOOTH_MAXIMUM = 29
LENGTH3 = 30
MULTIPLY_ADD = 31
SELECT = 32
OUTLINE = 33
GRID2 = 34
GRID3 = 35
MESH = 36
