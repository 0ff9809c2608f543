"""The impact with the lowest ratio on one chain, by scipy's differential evolution: a sampler for `find = "own"`."""

import queue
import threading

import numpy as np
from scipy.optimize import differential_evolution


class Sampler:
    """Scipy calls a function and waits for its values; it does so in a thread, which is asked and told in turn."""

    def __init__(self, axes):
        self.lengths = [len(axes["M_over_M0"]), len(axes["V_over_V0"])]
        self.asked, self.told = queue.Queue(), queue.Queue()
        threading.Thread(target=self.evolve, daemon=True).start()

    def evolve(self):
        try:
            differential_evolution(
                self.values,
                [(0, n - 1) for n in self.lengths],
                integrality=[True, True],  # places on the axes
                vectorized=True,
                updating="deferred",  # a whole generation at once: a round
                popsize=12,
                maxiter=8,
                polish=False,
                rng=1,  # its own seed: the same choice in every run
            )
        finally:
            self.asked.put(np.empty((0, 4), int))  # it is over

    def values(self, x):
        places = np.zeros((x.shape[1], 4), int)  # the first N, the first zeta_T
        places[:, 2:] = np.rint(x).T
        self.asked.put(places)
        rows = self.told.get()
        calm = (rows["status"] == b"done") & ~rows["chaotic"]
        return np.where(calm, rows["ke_ratio"], 1e3)

    def ask(self):
        return self.asked.get()

    def tell(self, rows):
        self.told.put(rows)
