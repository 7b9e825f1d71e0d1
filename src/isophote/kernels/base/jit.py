"""The decorators of every compiled function.

`kernel` marks what Python calls: it frees the interpreter while it runs and is cached on disk.
`device` marks what kernels call: it is compiled into them, and gets no machine code or Python entry of its own, which
would be two thirds of the time that compiling takes.

Arithmetic is IEEE's, but for contraction (`a * b + c` may be rounded once) and the sign of zero; division by zero gives
infinity, as in NumPy. `exact_kernel` and `exact_device` round every operation by itself: rounding errors that are to be
known, as in predicates, would be lost to contraction. Each operation carries its own permission, so a function marked
exact stays so within a kernel that is not.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import njit
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import register_pass
from numba.core.typed_passes import NativeLowering

from isophote.kernels.base import cache

__all__ = ["device", "exact_apart", "exact_device", "exact_inline", "exact_kernel", "kernel"]

cache.install()

_CONTRACT = {"contract", "nsz"}
# Said outright: what says nothing is compiled as its first caller is.
_EXACT = False


@register_pass(mutates_CFG=True, analysis_only=False)
class _DeviceLowering(NativeLowering):
    """Lowering to LLVM's language only; kernels link it and make machine code of all together."""

    _name = "isophote_device_lowering"

    def run_pass(self, state):
        flags = state.flags
        flags.no_compile = flags.no_cpython_wrapper = flags.no_cfunc_wrapper = True
        super().run_pass(state)
        result = state["cr"]
        # Numba knows compiled functions by their entry for Python. A bound method of a new object is an entry like no
        # other, and fails when it is called.
        entry = object().__reduce_ex__
        state.targetctx.insert_user_function(entry, result.fndesc, [state.library])
        state["cr"] = result._replace(cfunc=entry)
        return True


@register_pass(mutates_CFG=True, analysis_only=False)
class _ApartLowering(_DeviceLowering):
    """As `_DeviceLowering`, but optimised here, once, and never again or into its callers.

    Every function is otherwise optimised again with each of its callers, and theirs.
    """

    _name = "isophote_apart_lowering"

    def run_pass(self, state):
        super().run_pass(state)
        library = state.library
        library._ensure_finalized()
        for compiled in library._final_module.functions:
            if not compiled.is_declaration:
                compiled.add_function_attribute("noinline")
                compiled.add_function_attribute("optnone")
        return True


@register_pass(mutates_CFG=True, analysis_only=False)
class _InlineLowering(_DeviceLowering):
    """As `_DeviceLowering`, and every caller gets a copy."""

    _name = "isophote_inline_lowering"

    def run_pass(self, state):
        super().run_pass(state)
        compiled = state.library._final_module.get_function(state["cr"].fndesc.llvm_func_name)
        compiled.add_function_attribute("alwaysinline")
        return True


class _DeviceCompiler(CompilerBase):
    lowering = _DeviceLowering

    def define_pipelines(self):
        builder = DefaultPassBuilder.define_nopython_pipeline(self.state)
        builder.passes = [
            (self.lowering, why) if step is NativeLowering else (step, why) for step, why in builder.passes
        ]
        builder.finalize()
        return [builder]


class _ApartCompiler(_DeviceCompiler):
    lowering = _ApartLowering


class _InlineCompiler(_DeviceCompiler):
    lowering = _InlineLowering


def kernel(function: Callable[..., Any]) -> Any:
    """Compile a function that Python calls; see the module's text."""
    return njit(function, nogil=True, cache=True, error_model="numpy", fastmath=_CONTRACT)


def device(function: Callable[..., Any]) -> Any:
    """Compile a function that kernels call; see the module's text."""
    return njit(function, nogil=True, error_model="numpy", fastmath=_CONTRACT, pipeline_class=_DeviceCompiler)


def exact_kernel(function: Callable[..., Any]) -> Any:
    """Compile a function that Python calls, without contraction."""
    return njit(function, nogil=True, cache=True, error_model="numpy", fastmath=_EXACT)


def exact_device(function: Callable[..., Any]) -> Any:
    """Compile a function that kernels call, without contraction."""
    return njit(function, nogil=True, error_model="numpy", fastmath=_EXACT, pipeline_class=_DeviceCompiler)


def exact_apart(function: Callable[..., Any]) -> Any:
    """Compile a function that is long and seldom called, without contraction; callers compile as if it were short."""
    return njit(function, nogil=True, error_model="numpy", fastmath=_EXACT, pipeline_class=_ApartCompiler)


def exact_inline(function: Callable[..., Any]) -> Any:
    """Compile a function into each of its callers, without contraction: for the few calls of an innermost loop."""
    return njit(function, nogil=True, error_model="numpy", fastmath=_EXACT, pipeline_class=_InlineCompiler)
