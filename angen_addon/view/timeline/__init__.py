# SPDX-License-Identifier: GPL-3.0-or-later
"""The sensors' history in the timeline: strips, events, and the settings of both."""

from ...registering import of_modules

register, unregister = of_modules(__name__, "settings", "draw")
