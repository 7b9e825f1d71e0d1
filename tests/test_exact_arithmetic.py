"""Functions marked exact round every operation by itself, whoever calls them first."""

from __future__ import annotations

from typing import Any

import pytest

from isophote.kernels.base.jit import exact_apart, exact_device, exact_inline, exact_kernel, kernel

# (1 + e)² − (1 + 2 e) is e², which is lost where the square is rounded before the sum.
A = 1 + 2.0**-30
C = -1 - 2.0**-29


@exact_device
def by_device(a, b, c):
    return a * b + c


@exact_inline
def by_inline(a, b, c):
    return a * b + c


@exact_apart
def by_apart(a, b, c):
    return a * b + c


@kernel
def ask_device(a, b, c):
    return by_device(a, b, c)


@kernel
def ask_inline(a, b, c):
    return by_inline(a, b, c)


@kernel
def ask_apart(a, b, c):
    return by_apart(a, b, c)


@exact_kernel
def exactly(a, b, c):
    return a * b + c


@pytest.mark.parametrize("ask", [ask_device, ask_inline, ask_apart, exactly])
def test_products_are_rounded_before_sums(ask: Any) -> None:
    assert ask(A, A, C) == A * A + C == 0.0
