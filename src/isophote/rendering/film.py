"""The film in Python: sums over samples, what they say of each pixel, and how sure that is."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.kernels.trace.tables import FILM
from isophote.rendering.pixel_filter import FilterTable

__all__ = ["LUMINANCE", "Film"]

Array: TypeAlias = npt.NDArray[np.float64]
Counts: TypeAlias = npt.NDArray[np.int64]

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


class Film:
    """Sums over the samples of each pixel of a picture of `size` (width, height), behind one table for kernels.

    Kernels add samples; `target` (h, w) tells them how many each pixel shall have.
    """

    def __init__(self, size: tuple[int, int], table: FilterTable) -> None:
        width, height = size
        self._shape = height, width
        self._excess = table.excess
        layers = 2 if table.excess > 0 else 1
        self._total = np.zeros((layers, height, width, 3))
        self._squares = np.zeros((layers, height, width, 3))
        self._count = np.zeros((layers, height, width), np.int64)
        self.target: Counts = np.zeros((height, width), np.int64)
        self._packed = FILM.pack(
            total=self._total.reshape(-1, 3),
            squares=self._squares.reshape(-1, 3),
            count=self._count.reshape(-1),
            target=self.target.reshape(-1),
        )

    @property
    def words(self) -> npt.NDArray[np.int64]:
        """The table's words, for kernels."""
        return self._packed.words

    @property
    def count(self) -> Counts:
        """(h, w): samples of each pixel so far."""
        counts: Counts = self._count[0]
        return counts

    def sample_variance(self) -> Array:
        """(h, w, 3): variance of a pixel's samples; 0 where there are fewer than two."""
        n = self.count[..., None]
        mean = self._total[0] / np.maximum(n, 1)
        spread = np.maximum(self._squares[0] - n * mean**2, 0.0)
        result: Array = spread / np.maximum(n - 1, 1)
        return result

    def mean(self) -> Array:
        """(h, w, 3): colour of each pixel; 0 where it has no sample."""
        n = self.count[..., None]
        mean: Array = self._total[0] / np.maximum(n, 1)
        if not self._excess:
            return mean
        # Samples where the filter is negative, and the others; where one kind is missing, the other stands in.
        below = self._count[1][..., None]
        above = n - below
        under = self._total[1] / np.maximum(below, 1)
        over = (self._total[0] - self._total[1]) / np.maximum(above, 1)
        both: Array = (1 + self._excess) * over - self._excess * under
        return np.where((below > 0) & (above > 0), both, mean)

    def effective_count(self) -> Array:
        """(h, w): the number of samples by which their variance is divided to get that of the mean."""
        n = np.maximum(self.count, 1).astype(np.float64)
        if not self._excess:
            return n
        below = self._count[1]
        above = n - below
        shared = (1 + self._excess) ** 2 / np.maximum(above, 1) + self._excess**2 / np.maximum(below, 1)
        effective: Array = np.where((below > 0) & (above > 0), 1 / shared, n)
        return effective

    def variance(self) -> Array:
        """(h, w, 3): variance of the mean, as if samples were independent."""
        result: Array = self.sample_variance() / self.effective_count()[..., None]
        return result

    def noise(self) -> float:
        """Root mean square of the pixels' standard errors, in parts of the mean; infinite until it can be told."""
        if self.count.min() < 2:
            return np.inf
        level = float((self.mean() @ LUMINANCE).mean())
        error = float(np.sqrt((self.variance() @ LUMINANCE).mean()))
        return error / level if level > 0 else 0.0

    def counts_in_words(self) -> str:
        """How many samples pixels have: "64", or "16 to 512"."""
        least, most = int(self.count.min()), int(self.count.max())
        return f"{least}" if least == most else f"{least} to {most}"

    def channels(self) -> dict[str, npt.NDArray[np.generic]]:
        """What a picture keeps: "colour", "variance" and "samples"."""
        return {
            "colour": self.mean().astype(np.float32),
            "variance": self.variance().astype(np.float32),
            "samples": self.count.astype(np.int32),
        }
