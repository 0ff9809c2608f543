"""What the paper leaves open: other spring laws, other figures of merit, other lattices, disorder; and their page."""
