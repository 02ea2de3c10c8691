# SPDX-License-Identifier: GPL-3.0-or-later
"""Recordings of runs: stored in blend files, compared with the scene, baked to keyframes."""
