"""What a table is worth and what a run is doing, in words."""
