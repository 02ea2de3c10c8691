# SPDX-License-Identifier: GPL-3.0-or-later
"""Routines: what the people of a home do and when, drawn at random from a file.

`file` reads the activities and plans of a routine. `timetable` draws from them what each person
does at which time, or reads this from a diary.
"""
