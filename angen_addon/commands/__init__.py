# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line: what it takes, and what each verb does without a window."""
