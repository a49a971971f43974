"""Black bodies as Cycles has them: a colour of luminance 1 times sigma_SB 1e-6 / pi of the mix of 1 and T^4, per metre."""
import math

STEFAN_BOLTZMANN = 5.670374419e-8  # W m^-2 K^-4
COLDEST, HOTTEST, POINTS = 500.0, 6000.0, 48


def _lobe(x, centre, below, above):
    t = (x - centre) / (below if x < centre else above)
    return math.exp(-0.5 * t * t)


def _matching(nm):
    """CIE 1931 colour matching functions, fitted (Wyman, Sloan and Shirley 2013, multi-lobe fit)."""
    x = 1.056 * _lobe(nm, 599.8, 37.9, 31.0) + 0.362 * _lobe(nm, 442.0, 16.0, 26.7) - 0.065 * _lobe(nm, 501.1, 20.4, 26.2)
    y = 0.821 * _lobe(nm, 568.8, 46.9, 40.5) + 0.286 * _lobe(nm, 530.9, 16.3, 31.1)
    z = 1.217 * _lobe(nm, 437.0, 11.8, 36.0) + 0.681 * _lobe(nm, 459.0, 26.0, 13.8)
    return x, y, z


def colour(kelvin):
    """Linear Rec. 709 colour of a black body, of luminance 1; (0, 0, 0) below 500 K."""
    if kelvin < COLDEST:
        return 0.0, 0.0, 0.0
    xyz = [0.0, 0.0, 0.0]
    for nm in range(380, 781, 5):
        planck = (nm / 560) ** -5 / math.expm1(1.438776877e7 / (nm * kelvin))  # Planck's law, up to a factor
        for i, weight in enumerate(_matching(nm)):
            xyz[i] += weight * planck
    x, z = xyz[0] / xyz[1], xyz[2] / xyz[1]
    rgb = (3.2409699 * x - 1.5373832 - 0.4986108 * z, -0.9692436 * x + 1.8759675 + 0.0415551 * z,
           0.0556301 * x - 0.2039770 + 1.0569715 * z)
    return tuple(max(v, 0.0) for v in rgb)


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
