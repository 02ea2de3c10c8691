# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies: simulate a home many times with varied parameters, and show the results.

Runs are distributed by Dask to worker processes, each of which has Blender. Nothing outside this
folder imports it, and the extension's zip does not contain it.

`command` is the verb `study`. `study` reads the study's file and draws its runs. `settings` checks
them against the sensors of a home. `engine` sends runs to workers. `tasks` has what a worker
receives and returns, and `runs` simulates and measures there, with the changes to the home in
`changes`. `truth` scores days against what people did. `results` stores the results, and `report`
shows them.
"""
