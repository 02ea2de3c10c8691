# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether the extension may use the network."""

from __future__ import annotations

from ....sensor_logic.logs.error import AngenError

REFUSAL = (
    "Blender's online access is off: switch on Preferences ▸ System ▸ Allow Online Access, or "
    "start Blender with --online-mode"
)


def may_go_online() -> bool:
    """Return whether Blender allows this extension to use the network.

    The setting is for extensions. In the Python package, the user's own program decides.
    """
    if not __package__.startswith("bl_ext."):
        return True
    import bpy

    return bool(bpy.app.online_access)


def check_online() -> None:
    """Raise AngenError if Blender does not allow this extension to use the network."""
    if not may_go_online():
        raise AngenError(REFUSAL)
