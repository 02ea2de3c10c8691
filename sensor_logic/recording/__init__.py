# SPDX-License-Identifier: GPL-3.0-or-later
"""The readings of a run, and how they are kept as bytes."""
