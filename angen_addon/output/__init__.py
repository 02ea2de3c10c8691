# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the results of runs: logs, reports, and formats of other tools."""
