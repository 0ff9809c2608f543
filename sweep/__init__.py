"""Many impacts: spec, tasks, scheduler, table, command line."""
