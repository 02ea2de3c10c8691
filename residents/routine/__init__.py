# SPDX-License-Identifier: GPL-3.0-or-later
"""Routines: what the people of a home do when, drawn from a file that a user writes.

A file (`file.py`) says what activities there are and when each person does them; `timetable.py`
draws from it who does what from when to when; a diary tells that exactly instead.
"""
