# SPDX-License-Identifier: GPL-3.0-or-later
"""The report of a run: its content, its drawings (SVG) and its page (HTML)."""
