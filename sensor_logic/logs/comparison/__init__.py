# SPDX-License-Identifier: GPL-3.0-or-later
"""How two event logs differ."""
