# SPDX-License-Identifier: GPL-3.0-or-later
"""The appearance of infrared arrays, which look level from a wall and down from a ceiling."""

from __future__ import annotations

from ...appearance.appearance import Appearance
from ...appearance.housing import looking_level
from .explain import explain_array, lacking
from .figure import HOUSINGS, draw, edge_handle, frame_figure, pixels_figure, plan_rays

SECTIONS = (
    ("Detection", ("threshold", "min_pixels", "hold_time", "background", "background_time")),
    ("Pixels", ("columns", "rows", "horizontal_fov", "vertical_fov", "rays", "blur")),
    (
        "Device",
        (
            "netd",
            "noise_rise",
            "noise_corner",
            "frame_noise",
            "offset_sigma",
            "fixed_pattern",
            "frame_drift",
            "pixel_drift",
            "drift_time",
            "resolution",
            "coldest",
            "hottest",
            "settling_time",
            "mean_of",
        ),
    ),
    ("Output", ("report_step", "keep_frames")),
)

APPEARANCE = Appearance(
    HOUSINGS,
    looking_level,
    plan_rays,
    rays_figure=pixels_figure,
    reading_figure=frame_figure,
    drawn_fields=("frame_c",),
    handles=(edge_handle("horizontal_fov", 0), edge_handle("vertical_fov", 1)),
    explain=explain_array,
    lacking=lacking,
    sections=SECTIONS,
    details=draw,
)
