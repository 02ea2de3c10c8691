# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies: simulate a home many times with varied parameters, and show the results.

Dask distributes the runs to worker processes, each of which has Blender. The rest of the package
does not import this folder, and the extension's zip does not contain it.

- `command` is the command `angen study`.
- `study` reads the study's file and makes the list of runs.
- `settings` checks the study's values against the sensors of a home.
- `engine` sends runs to workers.
- `tasks` has the data that a worker receives and returns.
- `runs` simulates and measures runs in a worker, and `changes` changes the open home for a run.
- `truth` compares sensors' events with what residents did.
- `results` stores the results, and `report` shows them.
"""
