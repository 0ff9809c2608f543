"""The fourth-order splitting of the explicit scheme, as data.

S6 of S. Blanes and P. C. Moan, Practical symplectic partitioned Runge-Kutta and Runge-Kutta-Nystrom methods,
J. Comput. Appl. Math. 142 (2002) 313-330, table 2: a step is drift a_1 h, kick b_1 h, drift a_2 h, ..., drift a_7 h.

A kick moves v' = f + D v, D the dampers, by one Euler step: a factor 1 + b x for x = h D. The product over a step is
exp(x), as it must be, if the sum of the logarithms is x: to second and third order the two middle kicks make up for
all with factors 1 + b_3 x + c x^2 + d x^3, where
    c = (b_1^2 + b_2^2 + b_3^2) / 2,    d = b_3 c - (b_1^3 + b_2^3 + b_3^3) / 3.
"""

_A1, _A2, _A3 = 0.0792036964311957, 0.353172906049774, -0.0420650803577195
_B1, _B2 = 0.209515106613362, -0.143851773179818
_B3 = 0.5 - _B1 - _B2

DRIFTS = (_A1, _A2, _A3, 1.0 - 2.0 * (_A1 + _A2 + _A3), _A3, _A2, _A1)
KICKS = (_B1, _B2, _B3, _B3, _B2, _B1)
STAGES = len(KICKS)
MIDDLE_KICKS = (2, 3)  # the kicks that correct the dampers
SECOND = 0.5 * (_B1**2 + _B2**2 + _B3**2)
THIRD = _B3 * SECOND - (_B1**3 + _B2**3 + _B3**3) / 3.0
