# SPDX-License-Identifier: GPL-3.0-or-later
"""The report of a run: its numbers, and separately its drawings (SVG) and page (HTML)."""
