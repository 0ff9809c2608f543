"""Figure 10: the viscous force over wave number and frequency."""

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis import style
from analysis.colours import log_bar
from analysis.paper.recipe import Drawn, Recipe, Source
from analysis.paper.scenes import Seen

DECADES = 4  # of amplitude below the highest of all panels
CAPTION = (
    "Amplitude of the two-dimensional Fourier transform of the viscous force of figure 9, over wave number and "
    "frequency (f0 = sqrt(k_T/m_T)/2 pi), over the highest amplitude of all panels; above the bistable, below the "
    "linear chain; left N = 50, right N = 200. The white line is the dispersion of the linear chain, whose "
    "cut-off 2N is four times higher on the right. Both bistable chains carry force beyond it, the fine one up to "
    "the higher frequencies. A band that is level in wave number is force at the struck end alone."
)


def spectrum(one: Seen) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Wave number times L (k,), frequency over f0 (f,) of at least 0, amplitude (f, k) per sample.

    Unit-cell units: k per cell and omega per transit time times N. A Hann window in time keeps the end of the run from
    smearing over all frequencies.
    """
    shown, N = one["viscous_force"], one.scene.N
    window = np.hanning(len(shown["t"]))[:, None]
    amplitude = np.abs(np.fft.fftshift(np.fft.fft2(shown["force"] * window), axes=1)) / shown["force"].size
    omega = 2 * np.pi * np.fft.fftfreq(len(shown["t"]), (shown["t"][1] - shown["t"][0]) * N)
    half = omega >= 0
    k = np.fft.fftshift(2 * np.pi * np.fft.fftfreq(N))
    return k * N, omega[half] * N, amplitude[half]


def draw(source: Source) -> Drawn:
    """Bistable above, linear below."""
    from matplotlib.colors import LogNorm

    seen = source.scenes("fig10")
    spectra = [spectrum(one) for one in seen]
    top = max(float(amplitude.max()) for _, _, amplitude in spectra)
    figure, axes = style.canvas(2, 2, 7.6, 5.6, sharex="col", sharey="col")
    tables = []
    for ax, one, (k, f, amplitude) in zip(axes.flat, seen, spectra, strict=True):
        N = one.scene.N
        norm = LogNorm(10.0**-DECADES, 1, clip=True)
        mesh = ax.pcolormesh(-k, f, amplitude / top, norm=norm, cmap="viridis", shading="nearest", rasterized=True)
        ax.plot(k, 2 * N * np.abs(np.sin(k / N / 2)), color="white", linewidth=0.9, linestyle="--")
        ax.set(ylim=(0, 4 * N), xlim=(-np.pi * N, np.pi * N))
        low = f <= 4 * N
        grid = {"kx_L": np.tile(-k, low.sum()), "f_over_f0": np.repeat(f[low], len(k))}
        kept = (amplitude[low] / top).ravel()
        table = pd.DataFrame(grid | {"amplitude": kept})[kept >= 10.0**-DECADES]
        tables.append(table.assign(N=N, law=one.scene.law))
    style.letter(axes, [f"{one.scene.law}, $N$ = {one.scene.N}" for one in seen])
    style.outer_labels(axes, "$k_x L$", "$f_n/f_0$")
    log_bar(figure, mesh, "amplitude over the highest of all", "min", ax=axes)
    return Drawn(figure, pd.concat(tables, ignore_index=True))


RECIPES = (Recipe("10", "Fourier transform of the viscous force", CAPTION, draw),)
