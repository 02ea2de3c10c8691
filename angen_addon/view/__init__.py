# SPDX-License-Identifier: GPL-3.0-or-later
"""Shows sensors in the viewport and the timeline."""
