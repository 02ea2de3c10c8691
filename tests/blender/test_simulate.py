# SPDX-License-Identifier: GPL-3.0-or-later
"""*Simulate* loses no recording: it keeps a fresh one, asks before a loss, and undo restores it."""

from types import SimpleNamespace

import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.recording.results import RESULTS
from bl_ext.user_default.angen_sensors.angen_addon.runtime.running import running
from bl_ext.user_default.angen_sensors.angen_addon.scene import memory
from bl_ext.user_default.angen_sensors.angen_addon.scene.light import engine
from bl_ext.user_default.angen_sensors.angen_addon.view.readings import reading_text
from bl_ext.user_default.angen_sensors.operators.long_work import LongWork
from bl_ext.user_default.angen_sensors.operators.simulate import ANGEN_OT_simulate
from bl_ext.user_default.angen_sensors.sensor_logic import progress
from bl_ext.user_default.angen_sensors.sensor_logic.progress import Doing, TimeLeft
from light_stage import lamp
from panel_layout import drawn

ops = bpy.ops.angen


@pytest.fixture
def home(world):
    """Add a door that opens before a switch with noise, and a detector with a hold time."""
    world.door(13)
    world.switch("Switch", noise_sigma=0.01)
    world.pir("PIR", hold_time=1.0, noise_sigma=0.01)
    world.scene.frame_end = 72
    world.update()
    return world


def simulate(first, last, **given):
    """Simulate, as a step of undo."""
    return ops.simulate("EXEC_DEFAULT", True, frame_start=first, frame_end=last, **given)


def kept():
    return RESULTS.kept(bpy.context.scene)


def frames():
    found = kept().recording
    return found.frame_start, found.frame_end


def readings():
    assert kept().stale == ""
    return dict(kept().recording.tracks)


def sensor():
    return bpy.data.objects["Switch"].angen_sensor


@pytest.mark.parametrize(("first", "last"), [(1, 10), (20, 30), (50, 72)])
def test_frames_within_a_fresh_recording_leave_it_whole(home, first, last, capfd):
    simulate(1, 72)
    before = readings()
    assert simulate(first, last) == {"FINISHED"}
    assert frames() == (1, 72) and readings() == before
    told = f"Nothing has changed since frames 1 to 72 were recorded: frames {first} to {last}"
    assert told in capfd.readouterr().out


@pytest.mark.parametrize(("first", "last"), [(20, 60), (31, 60), (1, 60)])
def test_frames_that_adjoin_a_fresh_recording_read_as_in_one_run(home, first, last):
    simulate(1, 60)
    expected = readings()
    ops.clear_recording()
    simulate(1, 30)
    simulate(first, last)
    assert frames() == (1, 60) and readings() == expected


def test_frames_before_a_fresh_recording_take_in_its_frames(home):
    simulate(40, 60)
    simulate(20, 45)
    assert frames() == (20, 60)


def test_a_longer_recording_comes_back_by_undo(home, capfd):
    bpy.ops.ed.undo_push(message="made")
    simulate(1, 50)
    sensor().update_rate = 5.0
    bpy.ops.ed.undo_push(message="rate")
    simulate(1, 10)
    assert frames() == (1, 10) and "Undo brings back frames 1 to 50" in capfd.readouterr().out
    bpy.ops.ed.undo()
    assert frames() == (1, 50) and "Switch" in kept().stale
    bpy.ops.ed.undo()
    assert frames() == (1, 50) and kept().stale == ""
    bpy.ops.ed.redo()
    bpy.ops.ed.redo()
    assert frames() == (1, 10) and kept().stale == ""


def test_undo_of_the_first_run_loses_nothing(home):
    bpy.ops.ed.undo_push(message="made")
    simulate(1, 20)
    bpy.ops.ed.undo()
    assert frames() == (1, 20) and kept().stale == ""


def test_undo_after_the_file_was_opened_brings_its_recording_back(home, tmp_path):
    simulate(1, 20)
    path = str(tmp_path / "home.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    bpy.ops.ed.undo_push(message="opened")
    simulate(40, 60)
    assert frames() == (40, 60)
    bpy.ops.ed.undo()
    assert frames() == (1, 20) and kept().stale == ""


def test_many_runs_keep_few_recordings(home):
    for last in range(2, 12):
        sensor().update_rate = float(last)
        simulate(1, last)
    assert len(RESULTS._kept[home.scene.session_uid]) == 4 and frames() == (1, 11)


class Asked(LongWork):
    """The operator as it is invoked in a window; it records its question and its reports."""

    bl_idname, bl_label = ANGEN_OT_simulate.bl_idname, ANGEN_OT_simulate.bl_label
    frame_start = frame_end = -(2**31)
    without_light = replace = False

    def __init__(self, **given):
        self.__dict__ |= given
        self.questions, self.told, self.ran = [], [], False

    def report(self, kind, text):
        self.told.append(text)

    def __getattr__(self, name):
        found = getattr(ANGEN_OT_simulate, name)
        return found.__get__(self) if callable(found) else found

    def invoke_confirm(self, operator, event, message, **given):
        self.questions.append(message)
        return {"RUNNING_MODAL"}

    def press(self, monkeypatch):
        """Press the button; return the question, if there is one."""

        def run(operator, context, event):
            self.ran = True

        monkeypatch.setattr(LongWork, "invoke", run)
        context = SimpleNamespace(
            window=1,
            window_manager=self,
            scene=bpy.context.scene,
            view_layer=bpy.context.view_layer,
            mode="OBJECT",
            preferences=bpy.context.preferences,
            evaluated_depsgraph_get=bpy.context.evaluated_depsgraph_get,
        )
        ANGEN_OT_simulate.invoke(self, context, None)
        return "".join(self.questions)


def test_the_window_asks_before_a_longer_recording_is_lost(home, monkeypatch):
    simulate(1, 50)
    apart = Asked(frame_start=60, frame_end=70)
    assert apart.press(monkeypatch) == (
        "The recording has frames 1 to 50.\nFrames 60 to 70 replace it. Undo brings it back"
    )
    assert not apart.ran and frames() == (1, 50)
    sensor().update_rate = 5.0
    shorter = Asked(frame_start=1, frame_end=10)
    assert "frames 1 to 50, and is stale." in shorter.press(monkeypatch) and not shorter.ran


def test_cancel_in_the_question_changes_nothing_in_silence(home, monkeypatch):
    simulate(1, 50)
    before = kept()
    apart = Asked(frame_start=60, frame_end=70)
    assert apart.press(monkeypatch)
    # Blender ends the operator, of which nothing has run, also if it knows the scene already.
    apart._scene_uid = bpy.context.scene.session_uid
    ANGEN_OT_simulate.cancel(apart, bpy.context)
    assert kept() is before and apart.told == [] and not apart.ran


def test_the_window_asks_nothing_where_nothing_is_lost(home, monkeypatch):
    simulate(1, 50)
    within = Asked(frame_start=1, frame_end=10)
    assert not within.press(monkeypatch) and not within.ran
    assert "not simulated again" in within.told[0]
    for first, last in ((1, 50), (1, 60), (30, 60)):
        asked = Asked(frame_start=first, frame_end=last)
        assert not asked.press(monkeypatch) and asked.ran
    sensor().update_rate = 5.0
    as_long = Asked(frame_start=1, frame_end=50)
    assert not as_long.press(monkeypatch) and as_long.ran


# Without light


@pytest.fixture
def lit(home):
    """Add a lamp, and a light sensor with few light paths, to the home."""
    home.scene.angen_light_reference = 0
    lamp(home, "POINT", (0, 0, 3), energy=100.0)
    light = home.sensor("LIGHT", "Light", method="ILLUMINANCE", samples=16, update_rate=1.0)
    bpy.context.view_layer.objects.active = light
    home.update()
    return home


def test_a_run_without_light_says_so_and_claims_nothing_of_it(lit, tmp_path, capfd):
    assert simulate(1, 20, without_light=True) == {"FINISHED"}
    said = capfd.readouterr().out
    assert "Recorded frames 1 to 20: " in said and "Light sensors are not recorded" in said
    assert sorted(kept().recording.tracks) == ["PIR", "Switch"]
    lit.scene.frame_set(10)
    assert "Light sensors are not recorded" in drawn("ANGEN_PT_simulation").text
    assert drawn("ANGEN_PT_events").text == "Light is not in this recording: simulate with light"
    sensor = next(s for s in lit.sensors() if s.name == "Light")
    assert reading_text(sensor, lit.scene).text == "No reading"
    with pytest.raises(RuntimeError, match="simulate with light"):
        ops.event_jump()
    ops.export_events(filepath=str(tmp_path / "events.csv"))
    assert "LIGHT" not in (tmp_path / "events.csv").read_text()
    ops.export_report(filepath=str(tmp_path / "report.html"))
    assert "not simulated" in (tmp_path / "report.html").read_text()
    # A lamp makes no recording stale that has no light.
    bpy.data.lights[0].energy = 50.0
    lit.update()
    assert kept().stale == ""
    assert simulate(1, 20) == {"FINISHED"}
    assert "Light" in kept().recording.tracks
    assert "not recorded" not in drawn("ANGEN_PT_simulation").text


def test_the_button_without_light_is_there_where_light_is_sensed(lit):
    def buttons():
        return [text for text, *_ in drawn("ANGEN_PT_simulation").operators]

    assert "Without Light" in buttons()
    bpy.data.objects["Light"].angen_sensor.enabled = False
    lit.update()
    assert "Without Light" not in buttons()


def test_fresh_light_is_not_lost_in_silence(lit, monkeypatch):
    simulate(1, 20)
    before = readings()
    assert simulate(1, 20, without_light=True) == {"FINISHED"}
    assert simulate(5, 10, without_light=True) == {"FINISHED"}
    assert readings() == before
    longer = Asked(frame_start=1, frame_end=40, without_light=True)
    assert longer.press(monkeypatch) == (
        "The recording has frames 1 to 20.\n"
        "Frames 1 to 40, without light sensors, replace it. Undo brings it back"
    )
    simulate(1, 40, without_light=True)
    assert not Asked(frame_start=1, frame_end=40).press(monkeypatch)
    assert "frames 1 to 40" in Asked(frame_start=1, frame_end=10).press(monkeypatch)


def test_light_alone_cannot_be_left_out(lit):
    for name in ("Switch", "PIR"):
        bpy.data.objects[name].angen_sensor.enabled = False
    with pytest.raises(RuntimeError, match="only light sensors"):
        simulate(1, 5, without_light=True)


# The light's reference


def reference_steps(monkeypatch):
    """The shares of the runs from now on, with whether the reference was traced there."""
    steps = []
    run_steps = ANGEN_OT_simulate._steps

    def noted(operator, run):
        for doing in run_steps(operator, run):
            if hasattr(doing, "share"):
                steps.append((doing.share, "reference" in doing.text))
            yield doing

    monkeypatch.setattr(ANGEN_OT_simulate, "_steps", noted)
    return steps


def traces(steps, first=1, last=10):
    """Whether a run into nothing traces the reference."""
    steps.clear()
    if kept() is not None:
        ops.clear_recording()
    simulate(first, last)
    return any(traced for _, traced in steps)


@pytest.fixture
def referring(lit):
    lit.scene.angen_light_reference = 4096
    return lit


def test_the_reference_is_traced_once_for_a_scene(referring, monkeypatch):
    steps = reference_steps(monkeypatch)
    assert traces(steps)
    before = readings()
    assert not traces(steps) and readings() == before
    # No light depends on the parameters of other sensors.
    bpy.data.objects["PIR"].angen_sensor.pir.hold_time = 2.0
    assert not traces(steps)
    assert readings()["Light"] == before["Light"]
    bpy.data.lights[0].shadow_soft_size = 0.5
    assert traces(steps)
    memory.forget_file()
    assert traces(steps)


def test_a_longer_run_with_an_earlier_reference_reads_the_same(referring, monkeypatch):
    steps = reference_steps(monkeypatch)
    assert traces(steps, 1, 60)
    expected = readings()
    memory.forget_file()
    assert traces(steps, 1, 10) and not traces(steps, 1, 60)
    assert readings() == expected


def test_what_moves_makes_a_reference_of_its_own(referring, monkeypatch):
    steps = reference_steps(monkeypatch)
    assert traces(steps)
    bpy.data.objects["PIR"].location.x += 1.0
    assert traces(steps)
    referring.box((0.1, 0.1, 0.1), at=(1, 0, 0), name="shelf")
    referring.update()
    assert traces(steps)
    bpy.data.objects["shelf"].scale.x = 2.0
    assert traces(steps) and not traces(steps)


def test_the_reference_counts_in_the_share_that_is_done(referring, monkeypatch):
    steps = reference_steps(monkeypatch)
    monkeypatch.setattr(engine, "AT_ONCE", 256)
    monkeypatch.setattr(engine, "AT_ONCE_BEFORE", 256)
    referring.scene.angen_light_reference = 1 << 15
    assert traces(steps)
    shares = [share for share, traced in steps if traced]
    assert shares == sorted(shares) and shares[0] < 0.1 and 0.5 < shares[-1] < 1.0
    assert [share for share, _ in steps] == sorted(share for share, _ in steps)


def test_the_panel_has_the_bar_of_the_operator_at_work(home, monkeypatch):
    """Of an operator itself Blender gives another form of its name than that of its class."""
    screen = SimpleNamespace(screen=SimpleNamespace(areas=()))
    context = SimpleNamespace(
        window=screen,
        window_manager=SimpleNamespace(progress_update=lambda share: None),
        workspace=SimpleNamespace(status_text_set=lambda text: None),
    )

    def execute(operator, _context):
        operator._left = TimeLeft()
        operator._show(context, Doing(0.5, "frame 3, path-tracing the reference of the light"))
        return {"FINISHED"}

    monkeypatch.setattr(ANGEN_OT_simulate, "execute", execute)
    try:
        simulate(1, 2)
        with running():
            text = drawn("ANGEN_PT_simulation").text
    finally:
        progress.working = None
    assert "50 %. Esc ends" in text and "Frame 3, path-tracing the reference of the light" in text
