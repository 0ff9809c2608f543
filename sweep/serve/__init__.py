"""A run: rank 0 hands out batches, all ranks compute them; messages, progress, and when a run stops."""
