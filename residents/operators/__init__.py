# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators of residents and their days: one file for each task of a user."""
