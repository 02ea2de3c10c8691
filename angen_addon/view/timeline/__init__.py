# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw the sensors' history in the timeline: strips and events, with the settings of both."""
