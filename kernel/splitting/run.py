"""What one attempt at a run tells."""

from typing import NamedTuple


class Run(NamedTuple):
    """One integration from the impact to the end, by either scheme. Units of kernel.model."""

    status: int  # kernel.status code
    speed: float  # max |v_mid| over continuous time
    t: float  # when
    steps: int  # of the whole chain
    substeps: int  # of the contact zone
    evaluations: int  # of the chain's forces; those of the contact zone count as the part of the chain that it is
    site_evaluations: int  # the same, counting only the sites that were integrated
    energy: float  # total, at the end
