"""Rank 0 hands out batches, the others compute them; when to stop, who waits."""
