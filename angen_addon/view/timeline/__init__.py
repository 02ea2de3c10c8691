# SPDX-License-Identifier: GPL-3.0-or-later
"""The sensors' history in the timeline: strips, events, and the settings of both."""
