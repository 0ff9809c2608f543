"""The machine and the cluster that a sweep runs on."""
