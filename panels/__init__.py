# SPDX-License-Identifier: GPL-3.0-or-later
"""One file a place in the interface."""


def _modules() -> tuple:
    from . import load, physics_tab, presets, sidebar

    return (presets, physics_tab, sidebar, load)


def register() -> None:
    for module in _modules():
        module.register()


def unregister() -> None:
    for module in reversed(_modules()):
        module.unregister()
