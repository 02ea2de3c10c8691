# SPDX-License-Identifier: GPL-3.0-or-later
"""The light at sensors: `probe` renders it, `changes` says whether it can have changed."""
