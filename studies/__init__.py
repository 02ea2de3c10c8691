# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies: simulate a home many times with varied parameters, and show the results.

Dask distributes the runs to worker processes, each of which has Blender. Nothing outside this
folder imports it, and the extension's zip does not contain it.

- `command` is the command `angen study`.
- `study` reads the study's file and draws its runs.
- `settings` checks the runs against the sensors of a home.
- `engine` sends runs to workers.
- `tasks` has what a worker receives and returns.
- `runs` simulates and measures in a worker, and `changes` changes the home for that.
- `truth` scores days against what people did.
- `results` stores the results, and `report` shows them.
"""
