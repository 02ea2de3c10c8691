# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line: the options of `angen`, and its verbs, which work without a window.

A verb is a subcommand of `angen`, such as `simulate`.
"""
