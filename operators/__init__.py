# SPDX-License-Identifier: GPL-3.0-or-later
"""One file a verb."""


def _modules() -> tuple:
    from . import add, assign, bake, export, preset, recording, simulate

    return (add, assign, preset, simulate, bake, recording, export)


def register() -> None:
    for module in _modules():
        module.register()


def unregister() -> None:
    for module in reversed(_modules()):
        module.unregister()
