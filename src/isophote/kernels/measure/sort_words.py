"""Sorting runs of 64-bit words: mostly short ones, and now and then a very long one."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device

__all__ = ["sort_words"]

# Runs up to this length are sorted by insertion.
_SHORT = 48
_DIGIT = np.uint64(255)


@device
def sort_words(keys, spare, count):
    """Sort `count` words; `spare` is as long. Stars of a few faces are the rule, a radix sort guards against hubs."""
    if count > _SHORT:
        _radix_sort(keys, spare, count)
        return
    for i in range(1, count):
        key = keys[i]
        j = i
        while j > 0 and keys[j - 1] > key:
            keys[j] = keys[j - 1]
            j -= 1
        keys[j] = key


@device
def _radix_sort(keys, spare, count):
    """From the lowest byte to the highest, leaving out those that all words have in common."""
    source, target = keys, spare
    swaps = 0
    places = np.empty(256, np.int64)
    for digit in range(8):
        shift = np.uint64(8 * digit)
        places[:] = 0
        for i in range(count):
            places[(source[i] >> shift) & _DIGIT] += 1
        if places[(source[0] >> shift) & _DIGIT] == count:
            continue
        place = 0
        for value in range(256):
            held = places[value]
            places[value] = place
            place += held
        for i in range(count):
            value = (source[i] >> shift) & _DIGIT
            target[places[value]] = source[i]
            places[value] += 1
        source, target = target, source
        swaps += 1
    if swaps % 2 == 1:
        for i in range(count):
            keys[i] = spare[i]
