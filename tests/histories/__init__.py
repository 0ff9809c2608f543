"""Random histories of tables: what is computed, stopped, killed, damaged, shared out and joined in any order."""
