# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line: its options, and the work of each verb without a window."""
