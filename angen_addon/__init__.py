# SPDX-License-Identifier: GPL-3.0-or-later
"""What knows Blender: properties, the scene probes, the simulation, handlers, command line."""

from .registering import of_modules

# Later ones may need earlier ones.
_register, _unregister = of_modules(
    __name__, "properties", "residents.places.marks", "residents.settings", "view.active",
    "view.overlay", "view.places", "view.timeline", "coverage", "days.settings", ".operators",
    ".panels", "runtime.handlers", "commands.command_line",
)  # fmt: skip
_registered = False


def register() -> None:
    global _registered
    from .process import taking_down

    _register()
    _registered = True
    taking_down.expect(unregister)


def unregister() -> None:
    global _registered
    if _registered:
        _registered = False
        _unregister()
