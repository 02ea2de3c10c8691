# SPDX-License-Identifier: GPL-3.0-or-later
"""Recordings of runs: kept in blend files, compared with the scene, baked to keyframes."""
