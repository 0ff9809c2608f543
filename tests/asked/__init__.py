"""Random tables, every command that reads one, and whether its answer is right by the table's own rows."""
