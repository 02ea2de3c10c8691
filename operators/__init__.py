# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators of the extension, by topic."""
