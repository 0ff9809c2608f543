"""Several machines of a cluster, simulated on this one by Linux namespaces; network, disks and schedulers are real."""
