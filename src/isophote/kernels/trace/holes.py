"""Surfaces with holes: what tiles ask of them.

A cut-out has an opacity α at each place: so much of the light it treats as its material does, and 1 − α goes straight
on, as if nothing were there. What finds the way through are entries (hole_rays.py), which only scenes with cut-outs
call; there `materials.pass_holes` is not 0.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.surface import MATERIAL
from isophote.kernels.base.entry import call_entry, element_address, table_address
from isophote.kernels.base.jit import device
from isophote.kernels.brdf import contract
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.shading import write_surface

__all__ = ["has_holes", "pass_holes_of_rays", "pass_holes_of_shadows", "share_left", "stop_at_any", "surface_opacity"]

_ZERO, _ONE = np.float32(0), np.float32(1)
_START = np.int64(0)


@device
def has_holes(scene):
    """Whether the scene has cut-outs."""
    return scene.materials.pass_holes != 0


@device
def surface_opacity(scene, surface, hit, direction, radius, scratch):
    """α of a surface that a ray of unit `direction` met; `radius` as for `write_surface`."""
    materials = scene.materials
    if materials.cuts[np.int64(scene.surfaces.items[surface.item, MATERIAL])] < 0:
        return _ONE
    write_surface(scene, surface, hit, direction, radius, scratch)
    call_entry(materials.opacity, (table_address(scene), element_address(scratch, _START)))
    return scratch[contract.VALUE]


@device
def stop_at_any(wave, count):
    """Let rays of a wave go through where nothing is there at all, α = 0, and stop everywhere else."""
    for i in range(count):
        wave.floats[rows.PICK_U, i] = _ZERO


@device
def pass_holes_of_rays(scene, wave, count):
    """Take the hits of a wave on through holes: a ray stops where α is above the number in its row PICK_U, which is
    stretched to [0, 1) again where it goes on."""
    if has_holes(scene):
        call_entry(scene.materials.pass_holes, (table_address(scene), table_address(wave), np.int64(count)))


@device
def pass_holes_of_shadows(scene, wave, count):
    """Free the shadow rays that only cut-outs stand in the way of, and write what is left of each into its row LEFT."""
    if has_holes(scene):
        call_entry(scene.materials.shade_holes, (table_address(scene), table_address(wave), np.int64(count)))


@device
def share_left(scene, wave, i):
    """What is left of the light of a shadow ray that nothing blocks."""
    return wave.floats[rows.LEFT, i] if has_holes(scene) else _ONE
