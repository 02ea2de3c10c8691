# SPDX-License-Identifier: GPL-3.0-or-later
"""One file a place in the interface."""


def _modules() -> tuple:
    from . import physics_tab, sidebar

    return (physics_tab, sidebar)


def register() -> None:
    for module in _modules():
        module.register()


def unregister() -> None:
    for module in reversed(_modules()):
        module.unregister()
