# SPDX-License-Identifier: GPL-3.0-or-later
"""From the clock to a reading: what is evaluated when, and who senses then."""
