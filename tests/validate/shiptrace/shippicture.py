"""Pictures side by side as a JPEG."""
import numpy as np
from PIL import Image

# Linear Rec. 709 of radiances at 680, 550 and 440 nm, for looking only.
LIGHT = np.array([1.0, 1.0, 0.85])
GAP = 4


def shown(image, scale):
    value = np.clip(image * LIGHT * scale, 0, 1)
    return (255 * value ** (1 / 2.2) + 0.5).astype(np.uint8)


def save(path, found):
    """A line for each wind and Sun: a sea of ours, the mean of ours, the
    reference's."""
    lines = []
    for pictures in found.values():
        scale = 0.6 / np.percentile(pictures["reference"].mean(-1), 97)
        columns = []
        for name in ("one", "ours", "reference"):
            image = shown(pictures[name], scale)
            gap = np.full((image.shape[0], GAP, 3), 255, np.uint8)
            columns += [image, gap]
        line = np.concatenate(columns[:-1], 1)
        lines += [line, np.full((GAP, line.shape[1], 3), 255, np.uint8)]
    picture = np.concatenate(lines[:-1], 0)
    Image.fromarray(picture).save(path, quality=80, optimize=True)
