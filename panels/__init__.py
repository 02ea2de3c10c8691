# SPDX-License-Identifier: GPL-3.0-or-later
"""One file a place in the interface."""


def _modules() -> tuple:
    from . import events, load, overlay, physics_tab, presets, sidebar, table, warmth

    return (presets, physics_tab, table, events, sidebar, overlay, load, warmth)


def register() -> None:
    for module in _modules():
        module.register()


def unregister() -> None:
    for module in reversed(_modules()):
        module.unregister()
