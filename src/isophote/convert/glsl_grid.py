"""Tables of data as grids of samples, which GLSL reads from a texture."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

from isophote.shapes.field.data import GridData, MeshData, OutlineData

__all__ = ["GlslGrid", "grid_of"]

# Samples along the longest side of what is sampled, in the plane and in space.
_ACROSS = {2: 512, 3: 96}
# Room around it, in parts of its longest side.
_MARGIN = 0.15


@attrs.frozen(eq=False)
class GlslGrid:
    """A texture that a field's GLSL reads: the uniform `name` of type `sampler2D` or `sampler3D`.

    `values` is (ny, nx) or (nz, ny, nx) float32: one channel of single precision, x fastest. No filter is needed.
    """

    name: str
    values: npt.NDArray[np.float32]
    low: tuple[float, ...]
    step: float

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.values.ndim

    @property
    def source(self) -> str:
        """GLSL of the function `{name}At` of a point: linear between samples, beyond them as `GridData` says."""
        d = self.dimension
        size = f"vec{d}(" + ", ".join(f"{n}.0" for n in self.values.shape[::-1]) + ")"
        low = f"vec{d}(" + ", ".join(f"{v:.9g}" for v in self.low) + ")"
        corners = [
            f"texelFetch({self.name}, at + ivec{d}({', '.join(str(k >> axis & 1) for axis in range(d))}), 0).r"
            for k in range(2**d)
        ]
        for axis in range(d):
            corners = [f"mix({a}, {b}, w.{'xyz'[axis]})" for a, b in zip(corners[::2], corners[1::2], strict=True)]
        return f"""uniform highp sampler{d}D {self.name};
float {self.name}At(vec{d} p) {{
    vec{d} place = (p - {low}) / float({self.step:.9g});
    vec{d} held = clamp(place, vec{d}(0.0), {size} - 1.0);
    vec{d} cell = min(floor(held), {size} - 2.0);
    vec{d} w = held - cell;
    ivec{d} at = ivec{d}(cell);
    float value = {corners[0]};
    return length(vec2(max(value, 0.0), length(place - held) * float({self.step:.9g}))) + min(value, 0.0);
}}"""


def grid_of(name: str, data: Any) -> GlslGrid:
    """A table of data as a grid: itself, or the values of an outline or a mesh around it."""
    if isinstance(data, GridData):
        return GlslGrid(name, data.values, data.low, data.step)
    low, high = _box(data)
    d = len(low)
    margin = _MARGIN * float((high - low).max())
    low, high = low - margin, high + margin
    step = float((high - low).max()) / (_ACROSS[d] - 1)
    counts = np.maximum(np.ceil((high - low) / step).astype(int) + 1, 2)
    axes = [low[axis] + step * np.arange(counts[axis]) for axis in range(d)]
    points = np.meshgrid(*axes[::-1], indexing="ij")[::-1]
    return GlslGrid(name, np.asarray(data.value(*points), np.float32), tuple(low.tolist()), step)


def _box(data: OutlineData | MeshData) -> npt.NDArray[np.float64]:
    if isinstance(data, OutlineData):
        return np.asarray(data.bounds, np.float64)
    return np.stack([data.vertices.min(axis=0), data.vertices.max(axis=0)])
