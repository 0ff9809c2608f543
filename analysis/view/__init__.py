"""A table's page served on this machine only, growing while the sweep runs; a click computes that impact anew."""

from analysis.view.server import Server as Server
