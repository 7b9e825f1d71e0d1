"""What varies a colour or a number over a surface."""

from __future__ import annotations

__all__ = ["Texture"]


class Texture:
    """A colour for every place of a surface, from a picture or from a formula: the type of all textures, which are
    frozen values and may stand wherever a material takes one."""

    __slots__ = ()
