"""Radiosity as a method, and by itself."""

from __future__ import annotations

import time

import attrs
import numpy as np

from isophote.errors import RenderError
from isophote.lower.scene import lower_scene
from isophote.progress import ProgressLike, Reporter, reporter
from isophote.rendering.image import Image
from isophote.rendering.left_out import warn_of_left_out
from isophote.rendering.method import Job
from isophote.rendering.oddities import warn_of_oddities
from isophote.rendering.pool import checked_threads
from isophote.rendering.radiosity.coverage import Coverage
from isophote.rendering.radiosity.direct import spots_of
from isophote.rendering.radiosity.faces import Faces, bounded, faces_of
from isophote.rendering.radiosity.hierarchy import settle
from isophote.rendering.radiosity.solution import RadiositySolution, solution_of
from isophote.rendering.radiosity.tree import PatchTree
from isophote.rendering.radiosity.uniform import check_count, cut_evenly, settle_evenly
from isophote.rendering.settings import one_of, optional_positive, positive, whole
from isophote.scene.camera import Camera
from isophote.scene.light import RectLight
from isophote.scene.scene import Item, Scene

__all__ = ["Radiosity", "radiosity"]

# Where no patch is given, in parts of the scene's diagonal.
_PATCH = 1 / 100


@attrs.frozen
class Radiosity:
    """Radiosity: light between diffuse surfaces, solved once for all views, B = E + ρ ∫ B' v cosθ cosθ' / (π r²) dA'.

    Surfaces are cut into patches where light changes fast, down to edges of `patch` metres (None: a hundredth of the
    scene's diagonal, and less under lamps that are small and near), and linked in a hierarchy, nearer pairs by finer
    patches; links and patches are cut until what each may be off is below `error`, in parts of the mean radiosity.
    Light bounces until no patch changes by more than `residual` of the most that any reflects. `samples` rays a pixel
    show the result. All materials but Emitter are taken for Matte.

    With the method "gathering" (whose residual is in parts of the brightest patch, lamps included) or "shooting" all
    faces are cut evenly and light goes between all pairs of patches, by `form_factors`: "rays" between each two, or
    `directions` from each patch through the pixels of a "hemicube" or of a "hemisphere"; shooting sends the most
    light first, until the part `residual` of it is left. There are at most `max_links` form factors.

    Sources: Goral et al., "Modeling the Interaction of Light Between Diffuse Surfaces", SIGGRAPH 1984; Hanrahan,
    Salzman, Aupperle, "A Rapid Hierarchical Radiosity Algorithm", SIGGRAPH 1991.
    """

    patch: float | None = attrs.field(default=None, validator=optional_positive)
    error: float = attrs.field(default=0.01, validator=positive)
    residual: float = attrs.field(default=1e-4, validator=positive)
    samples: int = attrs.field(default=16, validator=whole(1, 1024))
    max_links: int = attrs.field(default=50_000_000, validator=whole(1, 2**31))
    method: str = attrs.field(default="hierarchical", validator=one_of(("hierarchical", "gathering", "shooting")))
    form_factors: str = attrs.field(default="rays", validator=one_of(("rays", "hemicube", "hemisphere")))
    directions: int = attrs.field(default=4096, validator=whole(12, 2**20))

    def __attrs_post_init__(self) -> None:
        if self.method == "hierarchical" and self.form_factors != "rays":
            raise RenderError(
                f'Radiosity: form_factors={self.form_factors!r} belongs to method="gathering" or "shooting"; '
                "the hierarchy links patches by rays and closed forms of its own"
            )

    def render(self, job: Job) -> Image:
        """The picture of the balance of light."""
        scene = job.scene.still()
        if scene.camera is None:
            raise RenderError("Radiosity: the scene has no camera")
        warn_of_oddities(job.scene)
        warn_of_left_out(job.scene, "Radiosity", holes=True, relief=True, gloss=True)
        began = time.monotonic()
        found = self.solve(scene, job.report, job.threads)
        image = found.image(scene.camera, job.size, samples=self.samples)
        metadata = {
            "method": repr(self),
            "patches": str(len(found.areas)),
            "links": str(found.links),
            "bounces": str(found.bounce_count),
            "residual": f"{found.residuals[-1]:.3e}",
            "seconds": f"{time.monotonic() - began:.3f}",
        }
        return image.with_(metadata=metadata)

    def solve(self, scene: Scene, report: Reporter, threads: int | None = None) -> RadiositySolution:
        """The solution behind the picture, for any number of views."""
        if not scene.items:
            raise RenderError("Radiosity: the scene has no items")
        patch = self.patch or _PATCH * float(np.linalg.norm(np.ptp(bounded(scene), axis=0)))
        report("cutting surfaces", 0.0)
        faces = faces_of(scene, patch)
        even = self.method != "hierarchical"
        if even:
            check_count(faces, patch, self.max_links)
        tables = lower_scene(_blockers(faces, scene), (1, 1), threads)
        report("cutting surfaces", 1.0)
        tree = PatchTree(faces, Coverage(tables, faces.solid, threads))
        if even:
            cut_evenly(tree, patch)
            return solution_of(
                settle_evenly(
                    tables,
                    tree,
                    method=self.method,
                    form_factors=self.form_factors,
                    directions=self.directions,
                    residual=self.residual,
                    report=report,
                    threads=threads,
                ),
                scene.lights,
            )
        settled = settle(
            tables,
            tree,
            spots_of(scene.lights),
            error=self.error,
            patch=patch,
            follow_lamps=self.patch is None,
            residual=self.residual,
            most_links=self.max_links,
            report=report,
            threads=threads,
        )
        return solution_of(settled, scene.lights)


def radiosity(
    scene: Scene, method: Radiosity | None = None, *, progress: ProgressLike = None, threads: int | None = None
) -> RadiositySolution:
    """Solve the balance of light in `scene`, by the settings of `method`, without taking a picture.

    `progress` and `threads` as for `render`. Raises `RenderError` for scenes in which nothing shines or no surface has
    bounds, and for more links or form factors than `method` allows, with an estimate.
    """
    if not isinstance(scene, Scene):
        raise RenderError(f"radiosity: give a Scene, not a {type(scene).__name__}; iso.studio makes one of a shape")
    chosen = Radiosity() if method is None else method
    if not isinstance(chosen, Radiosity):
        raise RenderError(f"radiosity: method must be a Radiosity(...), not {method!r}")
    crew = checked_threads(threads)
    _tell_of(scene)
    with reporter(progress) as report:
        return chosen.solve(scene.still(), report, crew)


def _tell_of(scene: Scene) -> None:
    # One call deeper than from `Radiosity.render`, so that warnings point to the call of iso.radiosity.
    warn_of_oddities(scene)
    warn_of_left_out(scene, "Radiosity", holes=True, relief=True, gloss=True)


def _blockers(faces: Faces, scene: Scene) -> Scene:
    """What stands in the way of light, as meshes, and the lights that are none."""
    lights = [light for light in scene.lights if not isinstance(light, RectLight)]
    # The tables need some camera; rays do not.
    return Scene([Item(mesh) for mesh in faces.meshes], lights=lights, camera=Camera((0, 0, 1), (0, 0, 0)))
