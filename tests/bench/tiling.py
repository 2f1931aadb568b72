#!/usr/bin/python3
"""How much of a picture comes back elsewhere in it:
   tests/bench/tiling.py [name=value of still …]
Draws the FFT's sea straight down from 10 m, 100 m, 1 km and 8 km and prints the
highest autocorrelation of its local contrast, 60 pixels away or more, and how
much of one is chance."""
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image

STILL = "build/release/bin/still"
NEAR = 60  # px: waves themselves are alike over so much
BOX = 24   # px: brightness and contrast are made even over twice that


def even(a):
    """Mean over boxes around each pixel."""
    total = np.pad(a, BOX, "reflect").cumsum(0).cumsum(1)
    total = np.pad(total, ((1, 0), (1, 0)))
    n = 2 * BOX
    box = total[n:, n:] - total[:-n, n:] - total[n:, :-n] + total[:-n, :-n]
    return box[:a.shape[0], :a.shape[1]] / n ** 2


def autocorrelation(a):
    contrast = a - even(a)
    contrast /= np.sqrt(even(contrast ** 2)) + 0.5
    size = [2 * n for n in a.shape]
    products = np.fft.irfft2(abs(np.fft.rfft2(contrast, size)) ** 2)
    count = np.fft.irfft2(abs(np.fft.rfft2(np.ones_like(a), size)) ** 2)
    y, x = np.meshgrid(*[np.fft.fftfreq(n, 1 / n) for n in size],
                       indexing="ij")
    counted = (count > 0.15 * a.size) & (np.hypot(x, y) > NEAR)
    r = products / np.maximum(count, 1) / (products[0, 0] / a.size)
    best = np.argmax(np.where(counted, r, -1))
    return r.flat[best], x.flat[best], y.flat[best], r[counted].std()


for height in (10, 100, 1000, 8000):
    with tempfile.NamedTemporaryFile(suffix=".png") as file:
        subprocess.run([STILL, file.name, "fft=1", f"height={height}",
                        "pitch=-90", "sun=70", "vis=200000", *sys.argv[1:]],
                       check=True, capture_output=True)
        grey = np.asarray(Image.open(file.name).convert("L")).astype(float)
    peak, x, y, chance = autocorrelation(grey)
    print(f"from {height:5} m: {peak:.3f} at ({x:.0f}, {y:.0f}) px, chance "
          f"{chance:.3f}", flush=True)
