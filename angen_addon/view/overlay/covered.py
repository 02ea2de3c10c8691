# SPDX-License-Identifier: GPL-3.0-or-later
"""What lies over a 3D view: sidebar, toolbar and headers, Blender's gizmos and texts. Pixels."""

from __future__ import annotations

from typing import Any

from .label_layout import Rect

# At an interface scale of 1: around the axes that turn the view, the buttons below them, and
# Blender's texts at the upper left.
ROUND_AXES, AXES_ONLY, BUTTON, BUTTONS = 26.0, 60.0, 34.0, 4
TEXT_WIDTH, TEXT_HEIGHT, STATISTICS = 230.0, 46.0, 150.0


def covered(area: Any, region: Any, space: Any, preferences: Any) -> list[Rect]:
    """The parts of a region (WINDOW) of a 3D view that something else lies over."""
    scale = preferences.system.ui_scale
    found = [rect for other in area.regions if (rect := _over(other, region)) is not None]
    left, right, top = 0.0, float(region.width), float(region.height)
    for rect in found:
        if rect[2] - rect[0] > 0.6 * region.width:
            top = min(top, rect[1]) if rect[1] > region.height / 2 else top
        elif rect[0] <= 0.0:
            left = max(left, rect[2])
        elif rect[2] >= region.width:
            right = min(right, rect[0])
    if space.show_gizmo and space.show_gizmo_navigate:
        found += _navigation(right, top, preferences.view, scale)
    if space.overlay.show_overlays and space.overlay.show_text:
        height = TEXT_HEIGHT + (STATISTICS if space.overlay.show_stats else 0.0)
        found.append((left, top - height * scale, left + TEXT_WIDTH * scale, top))
    return found


def _over(other: Any, region: Any) -> Rect | None:
    """Where another region of the area lies over this one."""
    if other.type == "WINDOW" or other.width <= 1 or other.height <= 1:
        return None
    left, low = float(other.x - region.x), float(other.y - region.y)
    right, high = left + other.width, low + other.height
    if right <= 0.0 or high <= 0.0 or left >= region.width or low >= region.height:
        return None
    return left, low, right, high


def _navigation(right: float, top: float, view: Any, scale: float) -> list[Rect]:
    """The axes, and the buttons below them."""
    size = AXES_ONLY
    if view.mini_axis_type == "GIZMO":
        size = view.gizmo_size_navigate_v3d + ROUND_AXES
    size *= scale
    low = top - size
    found = [(right - size, low, right, top)]
    if view.show_navigate_ui:
        found.append((right - BUTTON * 1.4 * scale, low - BUTTONS * BUTTON * scale, right, low))
    return found
