# SPDX-License-Identifier: GPL-3.0-or-later
"""Find reasons why sensors do not read what the user expects, with remedies."""
