# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw the history of sensors in the timeline: a row of states and events for each sensor."""
