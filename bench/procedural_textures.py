"""What a look-up in each kind of procedural texture takes, with and without a footprint.

python bench/procedural_textures.py
"""

from __future__ import annotations

import time

import numpy as np

import isophote as iso
from isophote.kernels.texture import contract
from isophote.kernels.texture.many import look_up_many
from isophote.lower.textures import TextureTable

COUNT, RUNS = 100_000, 7

KINDS = {
    "constant (Blend of equals)": iso.Blend(0.5, 0.5, 0.0),
    "Checker": iso.Checker(),
    "Stripes": iso.Stripes(),
    "Grid": iso.Grid(),
    "Gradient": iso.Gradient(["red", "gold", "navy"]),
    "Waves, sine": iso.Waves(),
    "ValueNoise": iso.ValueNoise(),
    "PerlinNoise": iso.PerlinNoise(),
    "SimplexNoise": iso.SimplexNoise(),
    "WorleyNoise, f1": iso.WorleyNoise(),
    "WorleyNoise, f2 - f1": iso.WorleyNoise(feature="f2-f1"),
    "Fbm, 6 octaves of Perlin": iso.Fbm(),
    "Fbm, turbulence": iso.Fbm(kind="turbulence"),
    "Marble": iso.Marble(),
    "Wood": iso.Wood(),
    "Placed PerlinNoise": iso.PerlinNoise(space="world"),
    "Formula, 8 operators": iso.Formula(lambda p: 0.5 + 0.5 * np.sin(9 * p[:, 0]) * np.cos(9 * p[:, 2])),
    "FieldTexture, ball and box": iso.FieldTexture(iso.sphere(1) | iso.box(1.2)),
    "ImageTexture, 512²": iso.ImageTexture(np.random.default_rng(0).integers(0, 256, (512, 512, 3)).astype(np.uint8)),
}


def nanoseconds(texture: iso.Texture, half_axis: float) -> tuple[float, float]:
    """(least, median) processor time of a look-up at random places in a cube."""
    table = TextureTable()
    node = np.int64(table.number(texture))
    packed = table.build()
    random = np.random.default_rng(1)
    records = np.zeros((COUNT, contract.WORDS), np.float32)
    records[:, contract.OWN : contract.OWN + 3] = random.uniform(-3, 3, (COUNT, 3))
    records[:, contract.WORLD : contract.WORLD + 3] = records[:, contract.OWN : contract.OWN + 3]
    records[:, contract.U : contract.V + 1] = random.uniform(0, 1, (COUNT, 2))
    for first in (contract.OWN_A, contract.OWN_B + 2, contract.WORLD_A, contract.WORLD_B + 2):
        records[:, first] = half_axis
    flat = records.reshape(-1)
    look_up_many(packed.words, node, flat)
    times = []
    for _ in range(RUNS):
        begin = time.process_time()
        look_up_many(packed.words, node, flat)
        times.append((time.process_time() - begin) / COUNT * 1e9)
    return min(times), float(np.median(times))


def main() -> None:
    print("| ns a look-up, one thread (least, median) | a place | over 0.05 | over 0.5 |")
    print("|---|---|---|---|")
    for name, texture in KINDS.items():
        cells = ["{:.0f} {:.0f}".format(*nanoseconds(texture, width / 2)) for width in (0.0, 0.05, 0.5)]
        print(f"| {name} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
