"""Names of 3MF: namespaces, parts and units (3MF Core Specification 1.3, Materials and Properties Extension 1.2)."""

from __future__ import annotations

__all__ = [
    "CONTENT_TYPES",
    "CORE",
    "MATERIALS",
    "MODEL",
    "MODEL_RELATION",
    "MODEL_TYPE",
    "RELATIONS",
    "RELATIONS_TYPE",
    "UNITS",
]

CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
MATERIALS = "http://schemas.microsoft.com/3dmanufacturing/material/2015/02"
MODEL_RELATION = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
MODEL_TYPE = "application/vnd.ms-package.3dmanufacturing-3dmodel+xml"
CONTENT_TYPES = "http://schemas.openxmlformats.org/package/2006/content-types"
RELATIONS = "http://schemas.openxmlformats.org/package/2006/relationships"
RELATIONS_TYPE = "application/vnd.openxmlformats-package.relationships+xml"

# Where the model lies in the package unless its relations tell otherwise.
MODEL = "3D/3dmodel.model"
UNITS = ("micron", "millimeter", "centimeter", "inch", "foot", "meter")
