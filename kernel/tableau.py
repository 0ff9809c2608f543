"""Dormand-Prince 5(4), the pair of MATLAB's ode45, as data.

Source: Dormand and Prince, J. Comput. Appl. Math. 6 (1980) 19; interpolant: Shampine, Math. Comp. 46 (1986) 135.
"""

import numpy as np

STAGES = 7
ORDER = 5

# fmt: off
C = np.array([0, 1/5, 3/10, 4/5, 8/9, 1, 1])
A = np.array([
    [0,           0,            0,           0,         0,            0,      0],
    [1/5,         0,            0,           0,         0,            0,      0],
    [3/40,        9/40,         0,           0,         0,            0,      0],
    [44/45,      -56/15,        32/9,        0,         0,            0,      0],
    [19372/6561, -25360/2187,   64448/6561, -212/729,   0,            0,      0],
    [9017/3168,  -355/33,       46732/5247,  49/176,   -5103/18656,   0,      0],
    [35/384,      0,            500/1113,    125/192,  -2187/6784,    11/84,  0],  # the last stage is the solution
])
# Fifth-order minus fourth-order weights.
E = np.array([71/57600, 0, -71/16695, 71/1920, -17253/339200, 22/525, -1/40])
# Column p: the weight of theta^(p+1) in the fourth-order continuous extension.
INTERPOLANT = np.array([
    [1, -183/64,      37/12,     -145/128],
    [0,  0,           0,          0],
    [0,  1500/371,   -1000/159,   1000/371],
    [0, -125/32,      125/12,    -375/64],
    [0,  9477/3392,  -729/106,    25515/6784],
    [0, -11/7,        11/3,      -55/28],
    [0,  3/2,        -4,          5/2],
])
# fmt: on

# Because u' = v, a stage's displacement follows from the accelerations alone:
# u_s = u + c_s h v + h^2 sum_j (A A)_sj a_j. The same numbers as the textbook form with half the arrays.
A_A = A @ A
E_A = E @ A
