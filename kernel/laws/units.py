"""The two scales of the paper that make its constants dimensionless."""

K_T = 225.7  # N/m, bulk stiffness, equal to c01
LENGTH = 1.0  # m
