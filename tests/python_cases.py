"""What the tests of the Python package share: its optional neighbours, a scene, and an array of densities."""
import os
import sys
import unittest

try:
    import numpy as np
except ImportError:
    np = None
try:
    import xarray
except ImportError:
    xarray = None

TOOL = sys.argv.pop(1) if len(sys.argv) > 1 and os.path.exists(sys.argv[1]) else None
needs_numpy = unittest.skipIf(np is None, "python3-numpy is not installed")
needs_xarray = unittest.skipIf(xarray is None, "python3-xarray is not installed")
# A sphere of fog under a sun, which every method renders in milliseconds.
FOG = {"camera": {"position": [0, 0, 4], "resolution": [24, 16]},
       "media": [{"bounds": [[-1, -1, -1], [1, 1, 1]], "sigma_s": 2, "sigma_a": 0.1, "g": 0.3}],
       "lights": [{"type": "directional", "direction": [0, -1, 0], "irradiance": [3, 2, 1]}],
       "render": {"method": "path", "spp": 4}}


def cloud(n=12):
    """A ball of density, (n, n, n) float32."""
    at = (np.arange(n) + 0.5) / n - 0.5
    z, y, x = np.meshgrid(at, at, at, indexing="ij")
    return np.maximum(0, 1 - 2 * np.sqrt(x * x + y * y + z * z)).astype(np.float32)


def run():
    """All tests of the program; a line for what they lack."""
    for name, module in (("python3-numpy", np), ("python3-xarray", xarray)):
        if module is None:
            print(f"skipped in part: {name} is not installed")
    unittest.main(verbosity=1)
