# SPDX-License-Identifier: GPL-3.0-or-later
"""Live readings: sensors sense at the playhead where there is no recording.

A live sensor publishes at the same frames as in a run. If the playhead jumps over updates, the
sensor starts anew, so that it never compares frames from before and after the jump.
"""

from __future__ import annotations

from collections.abc import Generator, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

from ...sensor_logic.clock import Clock
from ...sensor_logic.logs.error import AngenError
from ...sensor_logic.logs.fields import Field
from ...sensor_logic.model import Reading
from ...sensor_logic.progress import Doing, Work, finished
from ..scene import memory, outputs
from ..scene.instances import Uid
from ..scene.light.probe import LightRequest
from ..scene.sensors import Sensor, all_sensors, check, simulated
from .edits import EDITS
from .probes import Probes
from .running import running
from .sensor_runner import PendingUpdates, SensorRunner, SensorSteps, all_rays, single_update
from .trace import Trace

BEFORE_THE_START = "No sensor senses before the scene's first frame"
EDITED = "The scene was edited after this reading: scrub, play or simulate"
ELSEWHERE = "This reading is of another frame: scrub, play or simulate"
LIGHT_BEFORE = (
    "The scene was edited after this reading: press Measure Now, or move the playhead and wait"
)
LIGHT_AT_REST = "Light is measured when the playhead stops, or with Measure Now"


@dataclass(frozen=True)
class Published:
    """A reading, and the frame at which the sensor sensed."""

    reading: Reading
    frame: int


def has_reading(published: Published | None, quantity: Field) -> bool:
    """Return whether a reading has the field that its sensor shows as its main value.

    A reading as another kind, or by another method, has another unit.
    """
    return published is not None and published.reading.fields.get(quantity.name) is not None


class Live:
    """The live sensors of one scene, which sense at the playhead where there is no recording."""

    def __init__(self, scene: Any) -> None:
        self.scene_uid = scene.session_uid
        self.problems: dict[str, str] = {}
        # The last readings, by the sensor's name.
        self.readings: dict[str, Published] = {}
        self.outdated = True
        # Whether any sensor may have moved since the frame before.
        self._sensors_moved = True
        # The session uids of the sensors' objects.
        self._objects: set[int] = set()
        # The last frame whose readings were shown; None if there is none.
        self._frame: int | None = None
        self._is_light_held = False
        # Whether readings are shown. If not, rays are cast only to draw them in the viewport.
        self._publishes = True
        self._sensed_frame: int | None = None
        self._outputs: list[bool] = []
        self._probes = Probes(scene)
        self._waiting: dict[Uid, PendingUpdates] = {}
        self._light_updates: dict[str, PendingUpdates] = {}
        self._clock: Clock
        self._runners: list[SensorRunner] = []
        self._by_uid: dict[Uid, SensorRunner] = {}
        self._last_update: dict[Uid, int] = {}

    def follow(self, scene: Any, view_layer: Any, depsgraph: Any, publish: bool = True) -> None:
        """Sense at the present frame, and show the readings.

        Set `publish` to false while a recording is shown. The sensors then only cast their rays, to
        draw them in the viewport.
        """
        self._publishes, self._sensed_frame = publish, None
        is_next_frame = self._frame == scene.frame_current - 1
        self._frame, self._is_light_held = scene.frame_current if publish else None, False
        # A handler cannot evaluate subframes: live sensing is at whole frames.
        clock = Clock(scene.frame_start, scene.render.fps, scene.render.fps_base)
        if self.outdated or clock != self._clock or not self._sensors_are_the_same():
            self._find_sensors(view_layer, clock)
        if not self._runners:
            return
        step = scene.frame_current - scene.frame_start
        if step < 0:
            # Before the scene's start no sensor senses.
            self._forget()
            return
        runners = [s for s in self._runners if publish or s.casts]
        due = [(s, *update) for s in runners if (update := self._due(s, step))]
        pads = [runner.sensor for runner, _, _ in due if runner.sensor.kind.requires_forces]
        frame = scene.frame_current if pads or (publish and self._is_motion_needed(step)) else None
        self._sensors_moved = self._probes.caster.solids.has_noted(self._objects)
        if self._sensors_moved:
            self._probes.capture.note_edits()
        watching = [s for s in self._runners if s.senses_between and s.is_watched(step)]
        if due or watching or frame is not None:
            self._probes.look(depsgraph, step)
        if frame is not None:
            self._probes.look_at_motion(frame, pads)
        self._sensed_frame = scene.frame_current
        self._watch(watching, [s for s, _, _ in due], step)
        if not publish:
            for due_update in due:
                self._update_sensor(*due_update, step)
            self._relist_if_driven()
            return
        changed = [self._show_waiting(runner, step) for runner in self._runners]
        changed += [self._update_sensor(*update, step) for update in due]
        if not is_next_frame:
            changed += self._restore_outputs()
        if any(changed) and EDITS.outputs_are_driven():
            # Blender does not report what drivers now change.
            self._probes.caster.solids.forget()

    def _relist_if_driven(self) -> None:
        """List all solids (objects that rays can hit) anew if drivers read changed outputs.

        Blender does not report the changes that these drivers make.
        """
        values = [bool(runner.sensor.settings.active) for runner in self._runners]
        if values != self._outputs:
            self._outputs = values
            if EDITS.outputs_are_driven():
                self._probes.caster.solids.forget()

    def look_around(self, scene: Any, view_layer: Any, depsgraph: Any) -> None:
        """Cast all rays of all sensors at the present frame, to draw them in the viewport.

        The readings do not change. Do not call this method in a handler.
        """
        clock = Clock(scene.frame_start, scene.render.fps, scene.render.fps_base)
        if self.outdated or clock != self._clock or not self._sensors_are_the_same():
            # The next update lists the sensors once more, and senses.
            self._list(view_layer, clock)
            self.outdated = True
        self._probes.look(depsgraph)
        self._sensed_frame = None
        for runner in self._runners:
            found = None
            with suppress(AngenError):
                found = all_rays(runner.sensor, runner.clock, depsgraph, self._probes)
            runner.trace.copy_bundles(found or Trace(runner.sensor))
        self._relist_if_driven()

    def places_are_kept(self, scene: Any) -> bool:
        """Return whether no sensor has moved since the frame before.

        Also return false if the sensors have not sensed at the present frame.
        """
        return self._sensed_frame == scene.frame_current and not self._sensors_moved

    def runner(self, uid: Uid) -> SensorRunner | None:
        """Return the runner of the sensor with this uid.

        Return None if the sensor is switched off or has invalid parameters.
        """
        return self._by_uid.get(uid)

    def is_old(self, scene: Any) -> bool:
        """Return whether the frame has changed, or the scene was edited, since the last sensing."""
        return self.outdated or self._frame != scene.frame_current

    def hold_light(self) -> None:
        """Measure no light again until the playhead moves, unless the user asks for it.

        To measure light after each edit would take too long. Sensors without a reading are still
        measured: they would have nothing to show.
        """
        self._is_light_held = True

    def light_readings(self) -> dict[str, Published]:
        """Return the last readings of the light sensors, by name."""
        lit = {runner.sensor.name for runner in self._runners if runner.sensor.kind.requires_light}
        return {name: known for name, known in self.readings.items() if name in lit}

    def catch_up(self, scene: Any, view_layer: Any) -> None:
        """Sense anew at the present frame, because the scene was edited or the frame has changed.

        Do not call this method in a handler.
        """
        # Objects that were removed since the last evaluation are still listed, but freed.
        view_layer.update()
        was_held = self._is_light_held or bool(self.readings)
        with running():
            self.follow(scene, view_layer, view_layer.depsgraph)
            self._is_light_held = was_held
            # Writing the outputs must not count as an edit.
            view_layer.update()

    def why_old(self, scene: Any) -> str:
        """Return why the last readings are outdated, as a text; empty if they are not."""
        if scene.frame_current < scene.frame_start:
            return BEFORE_THE_START
        if self._frame is None:
            # Readings from before an undo.
            return EDITED if self.readings else ""
        if self.outdated:
            return EDITED
        if self._frame != scene.frame_current:
            return ELSEWHERE
        return ""

    def why_unlit(self, sensor: Sensor) -> str:
        """Return why the last light of a sensor is outdated, as a text; empty if it is not."""
        if sensor.name not in self._light_updates:
            return ""
        return LIGHT_BEFORE if self._is_kept_old(sensor) else LIGHT_AT_REST

    def _is_kept_old(self, sensor: Sensor) -> bool:
        """Return whether a light sensor keeps its old reading while light is held."""
        return self._is_light_held and has_reading(self.readings.get(sensor.name), sensor.reading)

    @property
    def edits(self) -> int:
        """The number of possible edits of the scene so far; pure changes of frame do not count."""
        return self._probes.capture.edits

    def _sensors_are_the_same(self) -> bool:
        try:
            return all(s.sensor.name_now == s.sensor.name for s in self._runners)
        except ReferenceError:
            return False

    def _find_sensors(self, view_layer: Any, clock: Clock) -> None:
        """List the sensors anew, and remove all readings except the readings of light sensors."""
        before = dict(self.readings)
        self._forget()
        self._list(view_layer, clock)
        self.readings = before
        # These readings are marked as old until the light is measured.
        self.readings = self.light_readings()

    def _list(self, view_layer: Any, clock: Clock) -> None:
        """Make a runner for each sensor of the view layer that is on and has valid parameters."""
        self._clock = clock
        self.outdated = False
        listed = all_sensors(view_layer)
        self._objects = {o.session_uid for s in listed for o in (s.object, *s.holders)}
        self._runners = []
        for sensor in simulated(listed):
            try:
                check(sensor)
            except AngenError as error:
                self.problems[sensor.name] = str(error)
            else:
                self._runners.append(SensorRunner(sensor, clock))
        self._by_uid = {runner.uid: runner for runner in self._runners}
        self._probes.set_sensors(runner.sensor for runner in self._runners)

    def _forget(self) -> None:
        self.problems.clear()
        self.readings.clear()
        self._last_update.clear()
        self._waiting.clear()
        self._light_updates.clear()

    def _due(self, runner: SensorRunner, step: int) -> tuple[int, bool] | None:
        """Return the number of the update that a sensor must make at a step; None if there is none.

        The second value says whether the sensor has also made the update before this one. If not,
        reset the sensor.
        """
        uid = runner.uid
        number = runner.schedule.last_update(step)
        last = self._last_update.get(uid)
        if number == last and not self._is_ahead(runner.sensor):
            return None
        follows = last is not None and number == last + 1 and runner.schedule.step(number) == step
        if not follows:
            runner.reset()
            runner.recall(step)
        self._last_update[uid] = number
        return number, follows

    def _is_ahead(self, sensor: Sensor) -> bool:
        """Return whether the sensor's last reading is of a later frame than the present one."""
        # The playhead went back. The scene may differ between the two frames.
        published = self.readings.get(sensor.name)
        return published is not None and self._frame is not None and published.frame > self._frame

    def _is_motion_needed(self, step: int) -> bool:
        """Return whether any pad has an update at this step, the step before or the one after."""
        schedules = [s.schedule for s in self._runners if s.sensor.kind.requires_forces]
        return any(
            schedule.step(schedule.last_update(beside)) == beside
            for schedule in schedules
            for beside in range(max(step - 1, 0), step + 2)
        )

    def _watch(self, watching: list[SensorRunner], due: list[SensorRunner], step: int) -> None:
        """Let the sensors `watching` sense between their updates, as swept optical switches do.

        Sensors in `due` are left out, since they make an update at this step.
        """
        for runner in watching:
            # The next update reports the error.
            with suppress(AngenError):
                if runner not in due:
                    number = runner.schedule.last_update(step) + 1
                    between = SensorSteps.of(step, number, due=False)
                    for update in runner.pending(between, self._probes):
                        update.readings()

    def _update_sensor(self, runner: SensorRunner, number: int, follows: bool, step: int) -> bool:
        """Make update `number` of a sensor; return whether its output `active` changed.

        `follows` says whether the sensor also made the update before this one. A light sensor's
        update is finished when its light is measured. If `follows`, a pad's update is finished at
        the next frame.
        """
        name, uid = runner.sensor.name, runner.uid
        self._light_updates.pop(name, None)
        try:
            update = single_update(runner, number, step, self._probes)
        except AngenError as error:
            self._show_problem(runner, error)
            return False
        if update is None:
            self.problems.pop(name, None)
            self.readings.pop(name, None)
            return False
        if update.request is not None:
            # A frame handler must not render.
            self._light_updates[name] = update
            return False
        if runner.sensor.kind.requires_forces and follows:
            # After a jump there is no frame before to compare with, so nothing to wait for.
            self._waiting[uid] = update
            return False
        return self._show(update)

    def _fail(self, lit: Iterable[PendingUpdates], error: AngenError) -> None:
        """Show an error in place of the readings of the light sensors with the updates `lit`."""
        for update in lit:
            name = update.runner.sensor.name
            self._light_updates.pop(name, None)
            self.readings.pop(name, None)
            self.problems[name] = str(error)

    @property
    def has_waiting_light(self) -> bool:
        """Return whether any light sensor waits for its light, and keeps no old reading."""
        return bool(self._waiting_light())

    def _waiting_light(self) -> list[PendingUpdates]:
        updates = self._light_updates.values()
        return [update for update in updates if not self._is_kept_old(update.runner.sensor)]

    def measure_waiting(self, scene: Any, view_layer: Any, at_most: int | None = None) -> None:
        """Measure the light at the present frame for the light sensors that wait for it.

        Measure at most `at_most` sensors, selected ones first; by default all.
        """
        view_layer.update()
        waiting = sorted(
            self._waiting_light(), key=lambda update: not update.runner.sensor.selected
        )
        lit = waiting[:at_most]
        try:
            finished(self._measure(scene, view_layer, lit))
        except AngenError as error:
            self._fail(lit, error)

    def measure_now(self, scene: Any, view_layer: Any, sensors: Sequence[Sensor]) -> Work[int]:
        """Measure the light of these sensors at the present frame, even if the scene was edited.

        Yield the progress before each picture, and return the number of sensors.
        Raise AngenError if the light of a sensor cannot be measured.
        """
        if self.is_old(scene):
            self.catch_up(scene, view_layer)
        for number, sensor in enumerate(sensors):
            update = self._light_update_now(scene, view_layer, sensor)
            for words in self._measure(scene, view_layer, [update]):
                text = ", ".join(filter(None, (sensor.name, words)))
                yield Doing(number / len(sensors), text, slow=True)
        return len(sensors)

    def _light_update_now(self, scene: Any, view_layer: Any, sensor: Sensor) -> PendingUpdates:
        """Return the update of a light sensor at the present frame, or raise AngenError."""
        if scene.frame_current < scene.frame_start:
            raise AngenError(BEFORE_THE_START)
        runner = self.runner(sensor.uid)
        if sensor.name in self.problems or runner is None:
            raise AngenError(
                self.problems.get(sensor.name, f"'{sensor.name}' is off: switch it on")
            )
        update = self._light_updates.get(sensor.name)
        if update is None:
            step = scene.frame_current - scene.frame_start
            runner.reset()
            self._probes.look(view_layer.depsgraph, step)
            number = runner.schedule.last_update(step)
            update = single_update(runner, number, step, self._probes)
        if update is None or update.request is None:
            raise AngenError(f"'{sensor.name}' is hidden, so it measures no light: show it")
        return update

    def _measure(
        self, scene: Any, view_layer: Any, lit: Sequence[PendingUpdates]
    ) -> Generator[str, None, None]:
        """Measure the light for the updates `lit`, and yield a text before each slow picture."""
        depsgraph = view_layer.depsgraph
        paths = scene.angen_light_reference
        requests = [as_exact(update.request, paths) for update in lit if update.request is not None]
        with running():
            try:
                found = yield from self._probes.measure(scene, view_layer, depsgraph, requests)
                for update in lit:
                    self._light_updates.pop(update.runner.sensor.name, None)
                    update.give_light(found)
                    update.runner.reset()
                    self._show(update, scene.frame_current)
            finally:
                # Outputs and the data for a picture must not count as an edit.
                view_layer.update()

    def _show_waiting(self, runner: SensorRunner, step: int) -> bool:
        """Show the update of a pad that has waited since the step before.

        Discard an update that has waited for longer. Return whether the output `active` changed.
        """
        update = self._waiting.pop(runner.uid, None)
        return update is not None and step == update.steps[0] + 1 and self._show(update)

    def _restore_outputs(self) -> list[bool]:
        """Write the last readings to outputs that differ; return whether each `active` changed."""
        return [
            outputs.show(runner.sensor, published.reading.active, published.reading.value)
            for runner in self._runners
            if (published := self.readings.get(runner.sensor.name)) is not None
        ]

    def _show(self, update: PendingUpdates, frame: int | None = None) -> bool:
        """Publish the reading of an update; return whether the output `active` changed.

        `frame` is the frame of the reading, by default the frame of the update.
        """
        sensor, sensed = update.runner.sensor, self._clock.frame_and_subframe(update.steps[0])[0]
        if sensor.kind.requires_forces:
            update.give_forces({sensed: self._probes.forces(sensor.uid, sensed)})
        try:
            reading = update.reading()
        except AngenError as error:
            self._show_problem(update.runner, error)
            return False
        frame = sensed if frame is None else frame
        self.readings[sensor.name] = Published(reading, frame)
        problem = reading.fields.get("problem", "")
        if problem:
            self.problems[sensor.name] = f"'{sensor.name}': {problem}"
        else:
            self.problems.pop(sensor.name, None)
        return self._publishes and outputs.show(sensor, reading.active, reading.value)

    def _show_problem(self, runner: SensorRunner, error: AngenError) -> None:
        """Show an error in place of the reading of a sensor, which then senses anew."""
        self.problems[runner.sensor.name] = str(error)
        self.readings.pop(runner.sensor.name, None)
        self._last_update.pop(runner.uid, None)


def as_exact(request: LightRequest, reference: int) -> LightRequest:
    """Return a light request with at least `reference` light paths.

    A run corrects noisy pictures by a light reference: a picture with that many light paths. A
    single picture has no reference, so it needs as many light paths itself.
    """
    if request.engine == "EEVEE":
        return request
    return replace(request, samples=max(request.samples, reference))


# The live sensors that were needed last.
_current: Live | None = None
# The session uid of a scene, and its light readings from before an undo, by the sensor's name.
_light_before: tuple[int, dict[str, Published]] = (0, {})


def live_of(scene: Any) -> Live:
    """Return the live sensors of a scene.

    They are kept until the live sensors of another scene are needed.
    """
    global _current, _light_before
    if _current is None or _current.scene_uid != scene.session_uid:
        _current = Live(scene)
        uid, found = _light_before
        _light_before = 0, {}
        if uid == scene.session_uid:
            # They are old: the scene was edited after them.
            _current.readings |= found
    return _current


def known_live() -> Live | None:
    """Return the live sensors that were needed last, of any scene; None if there are none."""
    return _current


def outdate() -> None:
    """Mark the live readings as outdated."""
    if _current is not None:
        _current.outdated = True


@memory.forgets_at_undo
def _forget() -> None:
    global _current, _light_before
    if _current is not None:
        # Undo does not change what was measured, and measuring light takes long.
        _light_before = _current.scene_uid, _current.light_readings()
    _current = None


@memory.forgets_at_load
def _forget_light() -> None:
    global _light_before
    _light_before = 0, {}
