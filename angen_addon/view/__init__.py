# SPDX-License-Identifier: GPL-3.0-or-later
"""Show sensors in the viewport and in the timeline."""
