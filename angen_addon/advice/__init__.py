# SPDX-License-Identifier: GPL-3.0-or-later
"""Find what keeps sensors from reading what the user expects, with ways to mend it."""
