# SPDX-License-Identifier: GPL-3.0-or-later
"""An artist's studio with a bath: one open room, turned out of the axes, for a couple and a cat."""
