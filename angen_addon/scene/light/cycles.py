# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure light with Cycles, in one temporary scene for all sensors (see docs/light_how.md).

Cycles takes longer to load a home than to trace the light paths. It drops a scene as soon as
another one is rendered. So one light scene serves all sensors. It is used again while only the
frame changes.

The *reference* is a rendering of the light at the first frame of a run, or of a part of a day. It
is a control variate, which removes noise from later readings. The reference has two pictures with
the same random numbers: one with as few light paths as a reading, and one with many. Their
difference estimates the error of the reading, and corrects it. Objects that have moved since then
add no bias. If the reading is darker than the reference, the difference is scaled in proportion, so
that a closed box reads 0. Such a ratio has a bias of the second order in the errors.

Light that differs much from the reference is traced with more paths. Few paths decide this, and may
miss new light. So each view has two pixels with independent random numbers, and one pixel that
differs is enough. If both miss new light, the reading is too low, which is much rarer
(tests/blender/test_light_reference.py).

References: Glasserman, Monte Carlo Methods in Financial Engineering, section 4.1, on control
variates; Cochran, Sampling Techniques, chapter 6, on ratio estimates; Rousselle, Jarosz, Novák,
Image-space control variates for rendering, 2016, on pictures.
"""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Generator, Hashable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any, TypeVar

import bpy
import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.model import Array, LightShare
from ....sensor_logic.physics import luminance
from ..instances import shown_objects
from ..timed import has_stiff_films
from . import engine, faces, views
from .changes import NEVER, LightState
from .engine import to_rec709
from .groups import LightGroups
from .scene import LightScene, Simulated, contents, is_portal, quietly, reference_frames
from .views import TWICE, Part, Picture, Seen, camera, share_out

# A light scene that Cycles renders again and again, and the light in each light group.
#
# No render lasts long: light paths are traced in parts, so that callers can show the progress, and
# can stop.

T = TypeVar("T")
# A generator that yields a text before each picture, empty for short ones, and returns a result.
Steps = Generator[str, None, T]
FIRST_PICTURE = "Cycles is loading the scene"
# The first number of light paths in a render, and the seconds that a render should last. The time
# of the last render decides how many pixels are rendered together.
PATHS, LONGEST_S, SHORTEST_S = 1 << 16, 0.4, 0.15
# Fewer paths take less time than the overhead of a render.
FEWEST = 1 << 12
# The name of light without a group: glowing surfaces, and lamps in instances.
OTHERS = "Other sources"
# The light without a group is a difference of single-precision sums: smaller shares count as 0.
ROUNDING = 1e-5


class CyclesScene(LightScene):
    """A temporary scene that Cycles renders, with each lamp and the world in a Cycles light group.

    It is at the present frame of the user's scene, except while a reference is traced.
    """

    def __init__(self, scene: Any, view_layer: Any, simulated: Simulated) -> None:
        super().__init__(scene, view_layer, simulated)
        self._paths_at_once = PATHS
        self._is_new = True
        self._folder = tempfile.TemporaryDirectory(
            prefix="angen_light_", dir=bpy.app.tempdir, ignore_cleanup_errors=True
        )
        self.has_stiff_films = has_stiff_films()
        # The fraction of a reference that is traced.
        self.done = 0.0
        self._pictures: list[Picture] = []
        lamps = [o for o in shown_objects(view_layer) if o.type == "LIGHT" and not is_portal(o)]
        self._lamps = [lamp.data for lamp in lamps]
        self.groups: LightGroups
        with quietly():
            self.__enter__()

    def _begin(self) -> None:
        scene = self.scene
        engine.set_up(scene, "CYCLES")
        render, settings = scene.render, scene.render.image_settings
        render.use_persistent_data = True
        if hasattr(settings, "media_type"):
            settings.media_type = "MULTI_LAYER_IMAGE"
        if hasattr(settings, "use_exr_interleave"):
            settings.use_exr_interleave = True
        settings.file_format = "OPEN_EXR_MULTILAYER"
        settings.color_depth, settings.exr_codec = "32", "NONE"
        # Facts of a render that are written into its file.
        for prop in render.bl_rna.properties:
            if prop.identifier.startswith("use_stamp_"):
                setattr(render, prop.identifier, False)
        scene.camera = camera(self.own)
        scene.collection.objects.link(scene.camera)
        self.groups = LightGroups(self, self._user_scene, self._lamps)

    def _lamp(self, obj: Any, lamp: Any) -> Any | None:
        return self.groups.add(self.own(lamp.copy()) if lamp is obj else lamp, obj.name)

    def _world(self) -> None:
        super()._world()
        world = self.scene.world
        if world is not None:
            original = self._user_scene.world
            if world == original:
                world = self.scene.world = self.own(world.copy())
            self.groups.add_world(world, original)

    def close(self) -> None:
        """Remove all datablocks and files of the scene."""
        super().close()
        self._folder.cleanup()

    def follow(self, reference: int | None = None) -> None:
        """Set the frame and settings as `LightScene.follow` does, and update the lamps."""
        super().follow(reference)
        self.groups.follow()

    def picture(self, method: Any, together: dict[int, Seen]) -> Picture:
        """Return a new `Picture` of the requests `together`, whose keys are their first pixels.

        `method` is the module that says what the pixels look at: `views` or `faces`.
        """
        with quietly():
            made = Picture(self, method, together)
        self._pictures.append(made)
        return made

    def drop(self, picture: Picture) -> None:
        """Remove a picture."""
        self._pictures.remove(picture)
        self.disown(*picture.made)

    def weights(self) -> Array:
        """Return the present factors (groups, 3) of the light groups.

        A factor is the power in the user's scene divided by the power in the light scene. The last
        row is for light without a group.
        """
        return np.concatenate([self.groups.weights(), np.ones((1, 3))])

    @property
    def sources(self) -> list[LightShare]:
        """The lamp or world of each light group, as a `LightShare` without a measured brightness.

        The last item is for light without a group.
        """
        return [*self.groups.sources, LightShare((), OTHERS, 0.0)]

    def traced(
        self,
        picture: Picture,
        first: int,
        last: int,
        doing: str = "",
        only: int | None = None,
        of: int = 0,
    ) -> Steps[Array]:
        """Trace light paths, and return the sums of their radiance.

        The generator yields a text for the user before each render.

        Parameters
        ----------
        picture
            The picture to render.
        first, last
            Numbers of the first light path of each pixel, and of the path after the last.
        doing
            The text to yield.
        only
            Index of the only request to render; None for all.
        of
            The total number of paths of a reference, to compute the progress `done`; 0 for other
            light.

        Returns
        -------
        Array
            Sums (groups, requests, pixels, 3), in scene colours.
        """
        total = np.zeros((1, *picture.pixels.shape, 3))
        self._show_only(picture)
        at_once = engine.at_once(self.scene)
        for start in range(first, last, at_once):
            count = min(at_once, last - start)
            parts = picture.parts(self._paths_at_once // count)
            for part in parts if only is None else [picture.part_of(only)]:
                self.done = start / of if of else self.done
                yield FIRST_PICTURE if self._is_new else doing
                began, was_new = time.perf_counter(), self._is_new
                total = total + count * self._render(start, count, part, picture)
                if not was_new:
                    self._adapt_paths(time.perf_counter() - began)
        return total

    def _show_only(self, picture: Picture) -> None:
        for other in self._pictures:
            other.show(other is picture)
        render, data = self.scene.render, self.scene.camera.data
        if render.resolution_x != picture.side:
            render.resolution_x = render.resolution_y = data.ortho_scale = picture.side

    def _adapt_paths(self, seconds: float) -> None:
        """Set how many paths one render may trace, from the seconds that the last render took."""
        if seconds > LONGEST_S:
            self._paths_at_once = max(FEWEST, self._paths_at_once // 2)
        elif seconds < SHORTEST_S:
            self._paths_at_once = min(PATHS, 2 * self._paths_at_once)

    def _render(self, start: int, count: int, part: Part, picture: Picture) -> Array:
        """Return the mean radiance (groups, requests, pixels, 3) of a part of a picture.

        `start` is the number of the first light path of each pixel, and `count` how many to trace.
        """
        engine.trace(self.scene, start, count)
        render, (row, column, end_row, end_column) = self.scene.render, part
        side, path = picture.side, Path(self._folder.name, "views")
        render.use_border = end_row - row < side
        render.border_min_x, render.border_max_x = column / side, end_column / side
        render.border_min_y, render.border_max_y = 1 - end_row / side, 1 - row / side
        render.filepath = str(path)
        # A scene given as an argument of the operator would be set to the frame of the user's.
        own = {"scene": self.scene, "view_layer": self.view_layer}
        with quietly(), bpy.context.temp_override(**own):
            bpy.ops.render.render(write_still=True)
        self._is_new = False
        layers = engine.read_layers(path.with_suffix(".exr"))
        passes = {
            name.rpartition(".")[2]: pixels.reshape(-1, 3)[picture.pixels]
            for name, pixels in layers.items()
        }
        whole = passes["Combined"]
        found = [passes[f"Combined_{name}"] for name in self.groups.names]
        left = whole - sum(found, np.zeros_like(whole))
        left[np.abs(left) < ROUNDING * np.abs(whole)] = 0.0
        return np.array([*found, left])


METHODS: dict[str, Any] = {"FOUR_WALL": views, "ILLUMINANCE": faces}
# The factor of the light paths where light differs much from the reference; and the share of the
# light that must have come or gone since the first frame for that.
CLOSER, ALIKE = 16, 0.1
CLOSELY, REFERENCE = (
    "measuring the changed light more closely",
    ("path-tracing the reference of the light"),
)
NOWHERE = np.zeros(0)
# The frame of the light scene: the present frame, or the frame of an earlier update or of a
# reference.
PRESENT, EARLIER = "present", "earlier"
# The most pictures and references that are stored.
PICTURES, REFERENCES = 64, 256
# Datablocks whose drivers may read the frame; drivers of lamps do not matter.
DRIVEN = (
    "armatures",
    "curves",
    "materials",
    "meshes",
    "node_groups",
    "objects",
    "shape_keys",
    "worlds",
)


@dataclass
class _Batch:
    """Light requests that are rendered together in one picture.

    Attributes
    ----------
    method
        The module for the method of measurement: `views` or `faces`.
    together
        The requests, by the first pixel of each.
    few
        The light paths of each pixel at an update.
    many
        The light paths of each pixel in the reference; 0 if there is no reference.
    """

    method: Any
    together: dict[int, Seen]
    few: int
    many: int

    @property
    def near(self) -> int:
        """The light paths of each pixel if the light differs much from the reference."""
        return min(CLOSER * self.few, self.many)

    @cached_property
    def pixels(self) -> Hashable:
        """A hashable key of the picture: the method, and the requests with their first pixels."""
        bits = tuple((pixel, request_key(seen.request)) for pixel, seen in self.together.items())
        return self.method.__name__, bits


@dataclass(frozen=True)
class Light:
    """The measured light of one sensor.

    Attributes
    ----------
    colours
        Linear Rec. 709 radiance (4, 3) of the four views, or irradiance (3,) in W/m².
    shares
        The part of the mean luminance that each source gives; None if unknown.
    """

    colours: Array
    shares: tuple[LightShare, ...] | None = None


class CyclesLight:
    """Measures the light of sensors with Cycles, update after update.

    Call `close` before other code can change the scene.

    Noise is removed with a reference: a precise rendering of an earlier frame (see the module).
    There is none for readings with as many paths as the reference, or whose request is not
    `steady`.

    Parameters
    ----------
    reference
        The number of light paths of each reading in the reference.
    """

    def __init__(self, reference: int = 0) -> None:
        self.reference = reference
        self._simulated = Simulated()
        self._user: tuple[Any, Any]
        self._contents: Hashable = None
        # The state at the last update.
        self._state = NEVER
        self._scene: CyclesScene | None = None
        self._stands: str | int = EARLIER
        self._pictures: dict[Hashable, Picture] = {}
        # The requests that share a picture, by the keys of all requests.
        self._together: dict[Hashable, list[dict[int, Seen]]] = {}
        # The light in pictures at this update, and in the references.
        self._found: dict[Hashable, Array] = {}
        self._references: dict[Hashable, dict[int, Array]] = {}
        self._frame_is_read: bool | None = None

    @property
    def reference_done(self) -> float:
        """The fraction of the present reference (a precise rendering) that is traced."""
        return self._scene.done if self._scene is not None else 0.0

    def recall(self, references: dict[Any, Any]) -> None:
        """Use the reference renderings of an earlier run of the same scene.

        New ones are added to the dictionary `references`.
        """
        self._references = references

    def look(self, scene: Any, view_layer: Any, state: LightState | None = None) -> None:
        """Compare the scene with its state at the last update. Call this at each update.

        If `state` is None, everything counts as changed.
        """
        before, now = self._state, self._contents
        self._state = state = state or LightState(*(count + 1 for count in before))
        if state.edits != before.edits:
            # Parents, modifiers and physics may have changed.
            self._simulated.look_again()
        if (state.values, state.edits) != (before.values, before.edits):
            now = contents(scene, view_layer, self._simulated)
        if (state.motion, state.values) != (before.motion, before.values):
            # A change of power alone leaves the light of each group as it is.
            self._found.clear()
        if self._scene is not None and (
            now != self._contents or self._reads_frame() or not self._scene.move_frozen_copies()
        ):
            self._close_scene()
        self._user, self._contents, self._stands = (scene, view_layer), now, EARLIER

    def light(self, requests: Sequence[Any]) -> Steps[tuple[dict[str, Light], list[str]]]:
        """Measure the light of sensors.

        All `LightRequest` objects must have the same method and number of paths.

        Returns
        -------
        tuple
            The light by name of the request, and notes for the user.
        """
        method, samples = METHODS[requests[0].method], requests[0].samples
        pixels = TWICE * method.COUNT
        few = max(1, math.ceil(samples / pixels))
        many = 0
        if self.refers(samples) and all(r.steady for r in requests) and not self._reads_frame():
            many = math.ceil(self.reference / pixels)
        found: dict[str, Light] = {}
        notes: list[str] = []
        for together in self._distribute(method, requests):
            batch = _Batch(method, together, few, many)
            light = yield from self._light(batch)
            found |= {s.request.name: one for s, one in zip(together.values(), light, strict=True)}
            notes += self._picture(batch).notes
        return found, notes

    def _distribute(self, method: Any, requests: Sequence[Any]) -> list[dict[int, Seen]]:
        """Distribute light requests over pictures; return a dictionary for each picture.

        The keys are the first pixels of the requests. `method` is the module that says what the
        pixels look at: `views` or `faces`. Two requests whose light paths could disturb each other
        get different pictures.
        """
        key = method.__name__, *map(request_key, requests)
        if key not in self._together:
            while len(self._together) >= PICTURES:
                self._together.pop(next(iter(self._together)))
            walls = views.StillWalls(*self._user, self._simulated)
            collide = partial(method.collide, self._user[0], walls)
            wanted = [Seen(request, method.lids(request, walls)) for request in requests]
            self._together[key] = share_out(wanted, method.COUNT, collide)
        return self._together[key]

    def refers(self, samples: int) -> bool:
        """Return whether readings with `samples` light paths are corrected by a reference."""
        return self.reference > samples

    def close(self) -> None:
        """Remove the light scene and all stored results."""
        self._close_scene()
        self._references = {}
        self._simulated, self._state = Simulated(), NEVER
        self._frame_is_read = None

    def _close_scene(self) -> None:
        scene, self._scene = self._scene, None
        self._pictures.clear()
        self._together.clear()
        self._found.clear()
        if scene is not None:
            scene.close()

    def _light(self, batch: _Batch) -> Steps[list[Light]]:
        scene = self._scene_at(PRESENT)
        weights, sources = scene.weights(), scene.sources
        state = self._contents, scene.groups.state
        if not batch.many:
            own = yield from self._by_few_paths(batch)
            return _light_of(batch, own.mean(2), weights, sources)
        first, begin = reference_frames(self._user[0], self._user[0].frame_float)
        stops = batch.few, batch.near, batch.many
        by_few, by_more, by_many = yield from self._reference(batch, stops, state, first)
        own = yield from self._by_few_paths(batch)
        found, known, by_many = own.copy(), by_few.copy(), by_many.copy()
        far = np.flatnonzero(_differs_much(own, by_few, weights).any(axis=1)).tolist()
        # Each change of the scene's frame takes time: trace all requests of a frame together.
        if begin != first:
            nearer = yield from self._nearer_references(batch, state, weights, begin, own, far)
            for one, (few, many) in nearer.items():
                known[:, one], by_many[:, one] = few, many
            far = [one for one in far if one not in nearer]
        for one in far:
            found[:, one] = yield from self._by_more_paths(batch, own, one)
            known[:, one] = by_more[:, one]
        passes = _corrected(found.mean(2), known.mean(2), by_many.mean(2))
        return _light_of(batch, passes, weights, sources)

    def _by_few_paths(self, batch: _Batch) -> Steps[Array]:
        """Return the light (groups, requests, 2, views, 3) by few paths; each view has 2 pixels."""
        if batch.pixels not in self._found:
            scene = self._scene_at(PRESENT)
            total = yield from scene.traced(self._picture(batch), 0, batch.few)
            self._found[batch.pixels] = _split_pixels(total) / batch.few
        return self._found[batch.pixels]

    def _by_more_paths(self, batch: _Batch, own: Array, index: int) -> Steps[Array]:
        """Return the light (groups, 2, views, 3) of the request `index` by `batch.near` paths.

        Each view has 2 pixels. The paths include the few paths that gave `own`, the light of all
        requests.
        """
        key = batch.pixels, index
        if key not in self._found:
            scene = self._scene_at(PRESENT)
            tracing = scene.traced(self._picture(batch), batch.few, batch.near, CLOSELY, index)
            more = _split_pixels((yield from tracing))
            self._found[key] = (batch.few * own[:, index] + more[:, index]) / batch.near
        return self._found[key]

    def _nearer_references(
        self,
        batch: _Batch,
        state: Hashable,
        weights: Array,
        begin: int,
        own: Array,
        far: Sequence[int],
    ) -> Steps[dict[int, tuple[Array, Array]]]:
        """Return, by index of the request, its light at the frame `begin` by few and by many paths.

        Both arrays have the shape (groups, 2, views, 3), since each view has 2 pixels. A request is
        left out if its present light also differs much from its light at `begin`.

        Parameters
        ----------
        batch
            The requests in one picture.
        state
            The state of the lamps.
        weights
            Factors (groups, 3) of the light groups (`CyclesScene.weights`).
        begin
            The frame at which this part of the day begins.
        own
            Light (groups, requests, 2, views, 3) of the present update.
        far
            Indices of the requests whose light differs much from the first frame.
        """
        found = {}
        for one in far:
            (few,) = yield from self._reference(batch, (batch.few,), state, begin, one)
            if not _differs_much(own[:, [one]], few[:, [one]], weights).any():
                stops = batch.few, batch.many
                few, many = yield from self._reference(batch, stops, state, begin, one)
                found[one] = few[:, one], many[:, one]
        return found

    def _reference(
        self,
        batch: _Batch,
        stops: tuple[int, ...],
        state: Hashable,
        frame: int,
        only: int | None = None,
    ) -> Steps[list[Array]]:
        """Return the light at the frame of a reference, for several numbers of light paths.

        Parameters
        ----------
        batch
            The requests in one picture.
        stops
            Increasing numbers of light paths of each pixel. Each number includes the paths before.
        state
            The state of the lamps.
        frame
            The frame of the reference.
        only
            Index of the only request to trace; None for all.

        Returns
        -------
        list
            For each number of paths, light (groups, requests, 2, views, 3); each view has 2 pixels.
        """
        key = batch.pixels, state, frame, only
        known = self._references.pop(key, {})
        for before, stop in zip((0, *stops), stops, strict=False):
            if stop not in known:
                tracing = self._scene_at(frame).traced(
                    self._picture(batch), before, stop, REFERENCE, only, stops[-1]
                )
                known[stop] = known.get(before, 0.0) + (yield from tracing)
        while len(self._references) >= REFERENCES:
            self._references.pop(next(iter(self._references)))
        self._references[key] = known
        return [_split_pixels(known[stop]) / stop for stop in stops]

    def _scene_at(self, where: str | int) -> CyclesScene:
        """Return the light scene at a reference's frame; PRESENT stands for the user's frame."""
        if self._scene is not None and self._stands != where:
            # Frozen copies were hidden for a reference, and would come back in another order.
            frozen = self._scene.frozen and isinstance(self._stands, int)
            if frozen or self._scene.has_stiff_films:
                self._close_scene()
        if self._scene is None:
            self._scene, self._stands = CyclesScene(*self._user, self._simulated), PRESENT
        if self._stands != where:
            self._scene.follow(where if isinstance(where, int) else None)
            self._stands = where
        return self._scene

    def _picture(self, batch: _Batch) -> Picture:
        assert self._scene is not None
        made = self._pictures.pop(batch.pixels, None)
        if made is None:
            made = self._scene.picture(batch.method, batch.together)
        self._pictures[batch.pixels] = made
        while len(self._pictures) > PICTURES:
            self._scene.drop(self._pictures.pop(next(iter(self._pictures))))
        return made

    def _reads_frame(self) -> bool:
        """Return whether a driver reads the frame of the user's scene.

        Such a driver would give a wrong value in a light scene at another frame. The answer is
        stored while light scenes are kept, since then nothing but the frame changes.
        """
        if self._frame_is_read is None:
            self._frame_is_read = any(
                _reads_frame(curve)
                for group in DRIVEN
                for datablock in getattr(bpy.data, group)
                for owner in (datablock, getattr(datablock, "node_tree", None))
                for curve in getattr(getattr(owner, "animation_data", None), "drivers", ())
            )
        return self._frame_is_read


def _reads_frame(curve: Any) -> bool:
    return any(
        target.id_type == "SCENE" and target.data_path.startswith("frame_")
        for variable in curve.driver.variables
        for target in variable.targets
    )


def _split_pixels(passes: Array) -> Array:
    """Reshape passes (groups, requests, pixels, 3) to (groups, requests, 2, views, 3).

    Each view has 2 pixels with independent random numbers: pixels 0 to views − 1 are the first
    pixels of all views, the others the second ones.
    """
    return passes.reshape(*passes.shape[:2], TWICE, -1, 3)


def _light_of(
    batch: _Batch, passes: Array, weights: Array, sources: Sequence[LightShare]
) -> list[Light]:
    """Return the light of each request.

    Parameters
    ----------
    batch
        The requests.
    passes
        Radiance (groups, requests, views, 3) of each light group.
    weights
        Factors (groups, 3) of the light groups (`CyclesScene.weights`).
    sources
        The source of each group's light.
    """
    light = batch.method.FACTOR * to_rec709(np.einsum("grvc,gc->rvc", passes, weights))
    colours = light if batch.method.COUNT > 1 else light[:, 0]
    apart = batch.method.FACTOR * to_rec709(np.einsum("grvc,gc->grvc", passes, weights))
    parts = np.nan_to_num(luminance(apart).mean(axis=2), nan=0.0, posinf=0.0, neginf=0.0)
    return [
        Light(one, tuple(replace(s, light=float(p)) for s, p in zip(sources, part, strict=True)))
        for one, part in zip(colours, parts.T, strict=True)
    ]


def _differs_much(own: Array, few: Array, weights: Array) -> NDArray[np.bool_]:
    """Return the mask (requests, 2) of the pixels whose light differs much from the reference.

    The first pixels of all views count together, and so do the second ones.

    The errors of update and reference then have little in common. That happens, for example, if a
    person is close to the sensor or its lamp.

    Parameters
    ----------
    own, few
        Light (groups, requests, 2, views, 3) of the update, and of the reference.
    weights
        Factors (groups, 3) of the light groups (`CyclesScene.weights`).
    """
    change = np.einsum("grtvc,gc->rt", np.abs(own - few), np.abs(weights))
    return np.asarray(change > ALIKE * np.einsum("grtvc,gc->rt", few, np.abs(weights)))


def _corrected(light: Array, few: Array, many: Array) -> Array:
    """Return the light of an update plus the difference (many − few) of the reference, at least 0.

    The difference is scaled down if the update is darker than the reference. `few` and `many` are
    the light of the reference by few and by many paths.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(light < few, light / few, 1.0)
        more = share * (many - few)
    # The probe leaves NaN light out, and adds a note.
    return light + np.nan_to_num(more, nan=0.0, posinf=0.0, neginf=0.0)


def request_key(request: Any) -> tuple[Hashable, ...]:
    """Return a hashable key that is equal for light requests with equal settings."""
    return repr(replace(request, matrix=NOWHERE)), request.matrix.tobytes()
