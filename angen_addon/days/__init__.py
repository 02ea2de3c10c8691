# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs days that residents live in a home: from a routine to events with who and what caused them.

`run.py` runs one day after the other in the open home; `folder.py` keeps them in a folder of files;
`command.py` is `angen day`.
"""
