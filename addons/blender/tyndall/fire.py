"""Black bodies as Cycles has them: a colour of luminance 1 times sigma_SB 1e-6 / pi of the mix of 1 and T^4, per metre."""
import math

STEFAN_BOLTZMANN = 5.670374419e-8  # W m^-2 K^-4
COLDEST, HOTTEST, POINTS = 200.0, 6000.0, 64

# Linear Rec. 709 of black bodies of luminance 1, from Tyndall's own table (src/scene/media/blackbody.c), by temperature, K.
# Below 800 K Cycles keeps the colour of 800 K.
COLOURS = ((800, 5.4053, -0.2005, -0.0823), (900, 4.9799, -0.0736, -0.0873), (1000, 4.5995, 0.0398, -0.0900),
           (1150, 4.1092, 0.1855, -0.0893), (1300, 3.7025, 0.3058, -0.0826), (1500, 3.2644, 0.4342, -0.0642),
           (1800, 2.7711, 0.5763, -0.0190), (2200, 2.3142, 0.7036, 0.0653), (2600, 1.9988, 0.7873, 0.1654),
           (3200, 1.6798, 0.8659, 0.3258), (4000, 1.4140, 0.9240, 0.5333), (5000, 1.2135, 0.9605, 0.7621),
           (6400, 1.0517, 0.9827, 1.0189), (9600, 0.8838, 0.9945, 1.3968))


def colour(kelvin):
    """Linear Rec. 709 colour of a black body, of luminance 1, between the rows of COLOURS linear in 1 / T."""
    kelvin = min(max(kelvin, COLOURS[0][0]), COLOURS[-1][0])
    above = next(i for i in range(1, len(COLOURS)) if COLOURS[i][0] >= kelvin)
    low, high = COLOURS[above - 1], COLOURS[above]
    part = (1 / kelvin - 1 / low[0]) / (1 / high[0] - 1 / low[0])
    return tuple(max(a + (b - a) * part, 0.0) for a, b in zip(low[1:], high[1:]))


def emission(kelvin, intensity):
    """Emission of Principled Volume for its Blackbody Intensity, W m^-3 sr^-1."""
    power = STEFAN_BOLTZMANN * 1e-6 / math.pi * (1 + (kelvin ** 4 - 1) * intensity)
    return tuple(power * c for c in colour(kelvin))


def curves(kelvin, intensity, maximum=None):
    """For each channel the emission over the values of the grid of a Field of temperatures; maximum: of its values."""
    scale, offset = kelvin.scale[0], kelvin.offset[0]
    hottest = HOTTEST if maximum is None else max(offset + scale * maximum, COLDEST * 1.1)
    step = (hottest / COLDEST) ** (1 / (POINTS - 2))
    temperatures = [COLDEST * step ** i for i in range(POINTS - 1)]
    values = [emission(t, intensity) for t in temperatures]
    start = ((COLDEST * 0.999 - offset) / scale, 0.0)
    return [[start] + [((t - offset) / scale, v[c]) for t, v in zip(temperatures, values)] for c in range(3)]
