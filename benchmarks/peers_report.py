# SPDX-License-Identifier: GPL-3.0-or-later
"""The section on other engines, from data."""

from __future__ import annotations

from typing import Any

from .tables import columns, percent, short, spread, table

OURS = "Ängen Sensors"
LIGHT_OURS, RADIANCE = "Ängen Sensors (Cycles)", "Radiance `rtrace`"
TEXT = """\
## Against other engines

The same {boxes} boxes (the home's walls and furniture, each as its bounding box, and a walker),
the same {rays} rays of seven detectors (120 rays, nine tilts) at each of ten looks a second, the
walker elsewhere at each; one process, one after the other. Milliseconds for a simulated second of
rays alone: moving the boxes is in, Blender's evaluation and the loading of the scene are not.
*Start* is the first look. Errors are against float64 ray and box, in closed form; *at edges*:
rays more than {edge:g} m off, which pass an edge on its other side; they are left out of the
errors.

{table}
{verdict}
{touch}{light}"""
LIGHT = """
**Light.** One reading of the home's seven light sensors by its lamps, with all that must be done
anew once something has moved: Cycles's copy of the scene, Radiance's octree ({compile:.1f} s). The
home is diffuse and grey for both ([light_benchmarks.md](light_benchmarks.md)). Errors, rms over the
{faces} sensors that get light, are against the same engine with many more rays; there both agree
within {apart} rms. At an error of {same} it takes {ours} s and {theirs} s. A run measures faster
than that: what stands still is kept from one reading to the next.

{table}"""
TOUCH = """
**Touch.** A box of 5 kg at rest on a pad, {exact:.2f} N. Ängen Sensors works forces out from what
Blender's Bullet moved, at 24 updates a second; MuJoCo steps its own physics ({step:g} ms) and its
touch sensor adds up contacts.

{table}
MuJoCo is faster for it simulates and senses in one compiled step, where forces are there to be
read; Blender hands none out, so they are solved for once more, in numpy. Its result on shared
loads stands in [pressure.md](pressure.md).
"""


def left_out(data: dict[str, Any]) -> list[str]:
    """What this run did without, in words."""
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
