# SPDX-License-Identifier: GPL-3.0-or-later
"""From the clock to the readings: which steps are looked at, what is kept of the scene there, and
how the sensors that are due sense it. `simulation` is a run over frames, `stage` what it, live
sensing and explanations have in common."""
