# SPDX-License-Identifier: GPL-3.0-or-later
"""The section on other engines, from data."""

from __future__ import annotations

from typing import Any

from .tables import columns, percent, short, spread, table

OURS = "Ängen Sensors"
LIGHT_OURS, RADIANCE = "Ängen Sensors (Cycles)", "Radiance `rtrace`"
TEXT = """\
## Against other engines

All engines get the same {boxes} boxes (the bounding boxes of the home's walls and furniture, and a
walker) and the same {rays} rays of seven detectors (120 rays, nine tilts) at ten updates a second
with a moving walker, one engine after the other in one process. Milliseconds for the rays of a
simulated second, including the motion of the boxes, without Blender's evaluation and the loading of
the scene. *Start*: the first update. Errors are relative to closed forms of ray and box in float64;
*at edges*: rays with errors above {edge:g} m, which pass an edge on its other side and are left out
of the other errors.

{table}
{verdict}
{touch}{light}"""
LIGHT = """
**Light.** One reading of the home's seven light sensors by its lamps, with everything that must be
repeated after something has moved: Cycles's copy of the scene, Radiance's octree ({compile:.1f} s).
The home is diffuse and grey for both ([light_benchmarks.md](light_benchmarks.md)). Errors, rms over
the {faces} sensors that get light, are relative to the same engine with many more rays; these
references agree within {apart} rms. For an error of {same} Cycles takes {ours} s and Radiance
{theirs} s. A whole run is faster, because Cycles reuses the still parts of the scene.

{table}"""
TOUCH = """
**Touch.** A box of 5 kg at rest on a pad, {exact:.2f} N. Ängen Sensors computes forces from the
motion that Blender's Bullet simulated, at 24 updates a second; MuJoCo steps its own physics
({step:g} ms), and its touch sensor adds up the contact forces.

{table}
MuJoCo is faster because it simulates and senses in one compiled step and has the forces already;
Blender does not expose them, so this extension solves for them again in numpy. Loads shared by
several pads: [pressure.md](pressure.md).
"""


def left_out(data: dict[str, Any]) -> list[str]:
    """The engines that this run left out, as texts."""
    found = [f"{name}, which is not installed" for name in data["missing"]]
    found += [] if data["touch"] else ["MuJoCo's touch sensor, which is not installed"]
    return found + ([] if data["light"] else ["Radiance (pyradiance), which is not installed"])


def section(data: dict[str, Any]) -> str:
    rows = data["rays"]
    ours = next(row for row in rows if row["engine"] == OURS)
    base = ours["ms_a_second"]["median"]
    text = table(
        (
            "engine",
            "ms a simulated second",
            "times ours",
            "start ms",
            "rms m",
            "worst m",
            "at edges",
        ),
        (
            (
                row["engine"],
                spread(row["ms_a_second"]),
                short(row["ms_a_second"]["median"] / base, 2),
                spread(row["start_ms"]),
                f"{row['rms_m']:.1e}",
                f"{row['worst_m']:.1e}",
                f"{row['at_edges']} of {row['rays']}",
            )
            for row in rows
        ),
    )
    return TEXT.format(
        boxes=data["boxes"],
        rays=data["rays_a_look"],
        edge=data["edge_m"],
        table=text,
        verdict=_verdict(data, base),
        touch=_touch(data["touch"]),
        light=_light(data["light"]),
    )


def ratios(data: dict[str, Any]) -> list[tuple[str, str, str]]:
    first, *others = data["rays"]
    base = first["ms_a_second"]["median"]
    rays = f"the rays of seven detectors among {data['boxes']} boxes"
    found = [(rays, row["engine"], _times(row["ms_a_second"]["median"] / base)) for row in others]
    if data["light"]:
        seconds = data["light"]["seconds"]
        what = f"seven light sensors, read once with an rms error of {data['light']['same']:.0%}"
        found.append((what, RADIANCE, _times(seconds[RADIANCE] / seconds[LIGHT_OURS])))
    return found


def _times(theirs: float) -> str:
    return f"{short(theirs, 2)} times as fast"


def _light(light: dict[str, Any] | None) -> str:
    if light is None:
        return "\nRadiance was not installed for this run: no light was compared.\n"
    return LIGHT.format(
        compile=light["compile_s"],
        faces=light["faces"],
        apart=percent(light["apart_rms"]),
        same=percent(light["same"]),
        ours=short(light["seconds"][LIGHT_OURS], 2),
        theirs=short(light["seconds"][RADIANCE], 2),
        table=columns(
            light["rows"],
            "engine",
            "paths, or divisions=rays",
            "seconds=seconds:spread",
            "rms error=rms:percent",
        ),
    )


def _verdict(data: dict[str, Any], base: float) -> str:
    faster = [
        f"{row['engine']} ({base / row['ms_a_second']['median']:.1f} times)"
        for row in data["rays"]
        if row["ms_a_second"]["median"] < base
    ]
    text = "No engine here is faster. "
    if faster:
        text = f"Faster than this layer: {', '.join(faster)}. "
    if any(name.startswith("Embree") for name in faster):
        text += (
            "Embree traces packets of rays in compiled, vectorised code, all of them at every "
            "look; this layer hands single rays from Python to Blender's BVH, and keeps up only "
            "by not casting those that nothing can have changed. Blender ships no Embree that "
            "scripts could call. "
        )
    text += (
        "MuJoCo meets boxes in closed form in float64, so its error is the smallest; it looks at "
        "every ray at every look."
    )
    if data["missing"]:
        text += f" Not installed for this run: {', '.join(data['missing'])}."
    return text + "\n"


def _touch(touch: dict[str, Any] | None) -> str:
    if touch is None:
        return "\nMuJoCo was not installed for this run: no touch sensor was compared.\n"
    rows = [
        (OURS, spread(touch["ours_ms_a_second"]), _off(touch["ours_error"])),
        ("Bullet in Blender, without sensing", spread(touch["bullet_ms_a_second"]), "–"),
        (
            "MuJoCo, physics and touch",
            spread(touch["mujoco_ms_a_second"]),
            _off(touch["mujoco_error"]),
        ),
    ]
    return TOUCH.format(
        exact=touch["exact_n"],
        step=touch["mujoco_step_s"] * 1e3,
        table=table(("", "ms a simulated second", "error"), rows),
    )


def _off(share: float) -> str:
    return "< 0.001%" if share < 1e-5 else percent(share)
