# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies: one home simulated many times with other parameters, by Dask outside Blender, and what
came of it. Nothing outside this folder imports it, and the extension's zip does not have it.

`command` is the verb `study`. `study` reads the file that a user writes and draws its runs;
`settings` holds them against the sensors of the home. `engine` hands runs to workers, each of which
has Blender: `tasks` is what it is given, `runs` simulates and measures that, `changes` is what it
changes of the home, and `truth` judges days by what people did. `results` keeps what comes back,
and `report` shows it.
"""
