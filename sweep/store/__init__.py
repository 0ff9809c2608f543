"""The table: rows that survive, and tables joined, repaired, exported."""
