"""What one integration tells, by whatever method."""

from typing import NamedTuple


class Run(NamedTuple):
    """One integration from the impact to the end, in the units of kernel.model.

    What the middle site reached in each part of the run stands in the array of crests that every integrator is given.
    """

    status: int  # kernel.status code
    speed: float  # max |v_mid| over continuous time
    t: float  # when
    steps: int  # of the whole chain and of the contact; retries count in this and what follows
    evaluations: int  # of the chain's forces; those of a part of the chain count as that part
    site_evaluations: int  # the same, counting only the sites that were integrated
    energy: float  # total, at the end; nan where the method does not tell it
    retries: int  # runs that blew up and were done again with smaller steps
