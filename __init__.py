# SPDX-License-Identifier: GPL-3.0-or-later
"""Ängen Sensors: ambient sensors in a home, authored and simulated in Blender.

The imports are inside the functions so that the pure parts can be imported without Blender.
"""


def register() -> None:
    from . import angen_addon

    angen_addon.register()


def unregister() -> None:
    from . import angen_addon

    angen_addon.unregister()
