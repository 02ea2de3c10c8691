# SPDX-License-Identifier: GPL-3.0-or-later
"""The report of a run: what there is to show (numbers), and apart from it how (SVG, HTML)."""
