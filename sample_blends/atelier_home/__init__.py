# SPDX-License-Identifier: GPL-3.0-or-later
"""An artist's studio with a bath for a couple and a cat: one open room, not along the axes."""
