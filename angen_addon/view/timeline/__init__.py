# SPDX-License-Identifier: GPL-3.0-or-later
"""The sensors' history in the timeline: strips, events, and the settings of both."""


def _modules() -> tuple:
    from . import draw, settings

    return (settings, draw)


def register() -> None:
    for module in _modules():
        module.register()


def unregister() -> None:
    for module in reversed(_modules()):
        module.unregister()
