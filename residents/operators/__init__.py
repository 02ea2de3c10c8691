# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators of residents and their days: one file for each thing that a user does."""
