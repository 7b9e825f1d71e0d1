"""Isophote: describe a 3D shape, render it, analyse it.

Names are loaded when they are first used, so that `import isophote` stays light.
"""

from __future__ import annotations

import importlib
from typing import Any

__version__ = "0.1.0"

# Public name → the module that defines it.
_HOME = {
    "AmbientOcclusion": "rendering.occlusion.picture",
    "AshikhminShirley": "scene.gloss",
    "Attribute": "shapes.mesh",
    "BakedOcclusion": "rendering.occlusion.bake",
    "Blinn": "scene.gloss",
    "Camera": "scene.camera",
    "Coated": "scene.compound",
    "Disk": "shapes.primitive.disk",
    "DiskLight": "scene.light",
    "Emitter": "scene.material",
    "Environment": "scene.light",
    "Error": "errors",
    "Exactness": "shapes.field.form",
    "Explanation": "rendering.explanation.explain",
    "FaceLabels": "shapes.mesh",
    "Field": "shapes.field.field",
    "Field2": "shapes.field.field2",
    "FieldPlot": "rendering.field_plot",
    "FileError": "errors",
    "GeometryError": "errors",
    "Glass": "scene.material",
    "Hits": "rendering.tracer",
    "Image": "rendering.image",
    "ImageTexture": "scene.image_texture",
    "IsophoteWarning": "errors",
    "Item": "scene.scene",
    "Material": "scene.material_base",
    "Matte": "scene.material",
    "Measured": "scene.measured",
    "Mesh": "shapes.mesh",
    "Metal": "scene.metal",
    "Mirror": "scene.material",
    "Mix": "scene.compound",
    "Motion": "scene.motion",
    "Occlusion": "rendering.occlusion.points",
    "OrenNayar": "scene.gloss",
    "OrthographicCamera": "scene.camera",
    "Parameter": "shapes.field.expression",
    "PathTrace": "rendering.path_trace",
    "Phong": "scene.gloss",
    "PixelFilter": "rendering.pixel_filter",
    "Plastic": "scene.compound",
    "PointLight": "scene.light",
    "Polygon": "shapes.primitive.polygon",
    "Principled": "scene.material",
    "Quadric": "shapes.primitive.quadric",
    "Radiosity": "rendering.radiosity.method",
    "RadiositySolution": "rendering.radiosity.solution",
    "RayTrace": "rendering.ray_trace",
    "RectLight": "scene.light",
    "RenderError": "errors",
    "Scene": "scene.scene",
    "SceneError": "errors",
    "SelfcheckReport": "checks.report",
    "Sky": "scene.light",
    "SphereLight": "scene.light",
    "SphereTrace": "rendering.sphere_trace",
    "SpotLight": "scene.spot_light",
    "Sun": "scene.light",
    "Texture": "scene.texture",
    "ThinGlass": "scene.thin_glass",
    "Tracer": "rendering.tracer",
    "Transform": "scene.transform",
    "Visits": "rendering.visits",
    "Ward": "scene.gloss",
    "ambient_occlusion": "rendering.occlusion.points",
    "arc": "shapes.field.field2",
    "bake_occlusion": "rendering.occlusion.bake",
    "box": "shapes.field.solids",
    "brdf_plot": "rendering.reflectance_plot",
    "capped_torus": "shapes.field.rounds",
    "capsule": "shapes.field.rounds",
    "circle": "shapes.field.field2",
    "cone": "shapes.field.rounds",
    "cylinder": "shapes.field.rounds",
    "difference": "shapes.field.operations",
    "distance_field": "convert.distance_field",
    "ellipsoid": "shapes.field.solids",
    "explain": "rendering.explanation.explain",
    "field": "shapes.field.function_form",
    "field2": "shapes.field.function_form",
    "form_factor": "rendering.radiosity.contours",
    "frame": "shapes.field.solids",
    "fresnel": "scene.optics",
    "image": "shapes.field.field2",
    "intersection": "shapes.field.operations",
    "link": "shapes.field.rounds",
    "load_brdf": "io.brdf_file",
    "load_image": "rendering.image",
    "load_mesh": "io.mesh_file",
    "load_metal": "io.ior_file",
    "load_scene": "io.scene_file",
    "load_texture": "io.texture_file",
    "mask": "convert.mask",
    "measure_brdf": "rendering.reflectance_table",
    "octahedron": "shapes.field.polyhedra",
    "plane": "shapes.field.solids",
    "polygon": "shapes.field.field2",
    "prism": "shapes.field.polyhedra",
    "pyramid": "shapes.field.polyhedra",
    "radiosity": "rendering.radiosity.method",
    "rectangle": "shapes.field.field2",
    "remesh": "analysis.remeshing.isotropic",
    "render": "rendering.render",
    "rounded_box": "shapes.field.solids",
    "rounded_cone": "shapes.field.rounds",
    "rounded_rectangle": "shapes.field.field2",
    "sample_pattern": "rendering.pattern",
    "save": "io.save",
    "screen_occlusion": "rendering.occlusion.screen",
    "segment": "shapes.field.field2",
    "show_tree": "rendering.show_tree",
    "selfcheck": "checks.run",
    "simplify": "convert.simplify",
    "slab": "shapes.field.solids",
    "sphere": "shapes.field.solids",
    "star": "shapes.field.field2",
    "studio": "scene.studio",
    "text": "shapes.field.field2",
    "texture_values": "lower.texture_probe",
    "to_glsl": "convert.glsl",
    "to_mesh": "convert.contour",
    "torus": "shapes.field.rounds",
    "triangulate": "convert.triangulate",
    "union": "shapes.field.operations",
    "unwrap": "convert.unwrap",
    "waves": "shapes.field.patterns",
}

__all__ = ["__version__", "analysis", *sorted(_HOME)]


def __getattr__(name: str) -> Any:
    if name == "analysis":
        return importlib.import_module("isophote.analysis")
    try:
        home = _HOME[name]
    except KeyError:
        raise AttributeError(f"module 'isophote' has no attribute {name!r}") from None
    value = getattr(importlib.import_module(f"isophote.{home}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return list(__all__)
