# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels: one file for each place in the interface."""


def _modules() -> tuple:
    from . import (
        active_sensor,
        coverage,
        day,
        doctor,
        events,
        load,
        overlay,
        physics_tab,
        places,
        presets,
        residents,
        sidebar,
        study,
        table,
        warmth,
    )

    # In the order of the sidebar's panels.
    return (
        presets,
        physics_tab,
        table,
        sidebar,
        events,
        active_sensor,
        overlay,
        load,
        warmth,
        coverage,
        residents,
        places,
        day,
        study,
        doctor,
    )


def register() -> None:
    for module in _modules():
        module.register()


def unregister() -> None:
    for module in reversed(_modules()):
        module.unregister()
