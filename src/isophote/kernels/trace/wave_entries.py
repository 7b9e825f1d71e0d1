"""What waves of rays ask for, as entries: compiled once, whatever the tiles that call them.

start_wave(scene, plan, film, wave, x0, x1, y0, y1, place)   count + 2³² · next pixel; see samples.start_paths
draw_numbers(plan, wave, count, dimension, row)              see samples.draw
closest_of_wave(scene, wave, count, coherent)                see batch.trace_rays
blocked_of_wave(scene, wave, count, coherent)                see batch.find_blocked

All but numbers are addresses of tables.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.entry import call_entry, entry, opener_at, table_address
from isophote.kernels.base.jit import device
from isophote.kernels.base.table import INT, Packed, Table
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.batch import find_blocked, trace_rays
from isophote.kernels.trace.samples import Tile, draw, start_paths
from isophote.kernels.trace.tables import FILM, PLAN, SCENE

__all__ = [
    "ENTRIES",
    "ask_blocked",
    "ask_closest",
    "ask_numbers",
    "ask_start",
    "blocked_of_wave",
    "closest_of_wave",
    "compile_entries",
    "draw_numbers",
    "pack_entries",
    "start_wave",
]

_BITS, _LOW = np.int64(32), np.int64(0xFFFFFFFF)

# Addresses of the entries.
ENTRIES = Table("WaveEntries", start=INT, draw=INT, closest=INT, blocked=INT)

_scene_at, _plan_at, _film_at, _wave_at = opener_at(SCENE), opener_at(PLAN), opener_at(FILM), opener_at(rows.WAVE)


@entry
def start_wave(scene_words, plan_words, film_words, wave_words, x0, x1, y0, y1, place):
    """Camera rays of the next paths of a tile."""
    scene, plan, film, wave = _scene_at(scene_words), _plan_at(plan_words), _film_at(film_words), _wave_at(wave_words)
    count, place = start_paths(scene, plan, film, Tile(x0, x1, y0, y1), place, wave)
    return np.int64(count) | np.int64(place) << _BITS


@entry
def draw_numbers(plan_words, wave_words, count, dimension, row):
    """Sample numbers of the wave's paths."""
    draw(_plan_at(plan_words), _wave_at(wave_words), count, dimension, row)
    return 0


@entry
def closest_of_wave(scene_words, wave_words, count, coherent):
    """First hits of the wave's rays."""
    trace_rays(_scene_at(scene_words), _wave_at(wave_words), count, coherent != 0)
    return 0


@entry
def blocked_of_wave(scene_words, wave_words, count, coherent):
    """Whether the wave's shadow rays meet anything."""
    find_blocked(_scene_at(scene_words), _wave_at(wave_words), count, coherent != 0)
    return 0


_ALL = (start_wave, draw_numbers, closest_of_wave, blocked_of_wave)


def compile_entries() -> None:
    """Compile all entries, or load them from the cache."""
    for each in _ALL:
        each.compile()


def pack_entries() -> Packed:
    """The table of all entries."""
    return ENTRIES.pack(**dict(zip(ENTRIES.fields, (each.address for each in _ALL), strict=True)))


@device
def ask_start(entries, scene, plan, film, tile, place, wave):
    """`start_paths` by its entry."""
    tables = table_address(scene), table_address(plan), table_address(film), table_address(wave)
    found = call_entry(entries.start, (*tables, tile.x0, tile.x1, tile.y0, tile.y1, place))
    return found & _LOW, found >> _BITS


@device
def ask_numbers(entries, plan, wave, count, dimension, row):
    """`draw` by its entry."""
    call_entry(entries.draw, (table_address(plan), table_address(wave), count, dimension, row))


@device
def ask_closest(entries, scene, wave, count, coherent):
    """`trace_rays` by its entry."""
    call_entry(entries.closest, (table_address(scene), table_address(wave), count, np.int64(coherent)))


@device
def ask_blocked(entries, scene, wave, count, coherent):
    """`find_blocked` by its entry."""
    call_entry(entries.blocked, (table_address(scene), table_address(wave), count, np.int64(coherent)))
