# SPDX-License-Identifier: GPL-3.0-or-later
"""The readings of a run: in memory, and as bytes for a file."""
