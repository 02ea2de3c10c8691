# SPDX-License-Identifier: GPL-3.0-or-later
"""What knows Blender: properties, the scene probes, the simulation, handlers, command line."""


def _modules() -> tuple:
    """Everything that registers, in order; later ones may need earlier ones."""
    from .. import operators, panels
    from . import coverage, properties
    from .commands import command_line
    from .days import settings as days
    from .residents import settings
    from .residents.places import marks
    from .runtime import handlers
    from .view import active, overlay, places, timeline

    return (
        properties,
        marks,
        settings,
        active,
        overlay,
        places,
        timeline,
        coverage,
        days,
        operators,
        panels,
        handlers,
        command_line,
    )


_registered = False


def register() -> None:
    global _registered
    from .process import taking_down

    for module in _modules():
        module.register()
    _registered = True
    taking_down.expect(unregister)


def unregister() -> None:
    global _registered
    if _registered:
        _registered = False
        for module in reversed(_modules()):
            module.unregister()
