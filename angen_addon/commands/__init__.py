# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line `angen`: its options, and its subcommands, which work without a window.

The code calls a subcommand, such as `angen simulate`, a verb.
"""
