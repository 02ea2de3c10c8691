# SPDX-License-Identifier: GPL-3.0-or-later
"""The event log, and what its fields hold."""
