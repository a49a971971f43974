/* Colours of spectra in linear Rec.709, and of what other formats give by name. */
#ifndef TY_IO_INTERCHANGE_SPECTRUM_H
#define TY_IO_INTERCHANGE_SPECTRUM_H

#include <stdbool.h>
#include <stddef.h>

/* A spectrum as pairs of a wavelength, nm, which ascend, and a value; linear between them and constant beyond. */
typedef struct ty_spectrum {
    const double* pairs;
    size_t count; /* of pairs */
} ty_spectrum;

double ty_spectrum_at(ty_spectrum spectrum, double nm);
/* Colour of light, of the luminance 1; black if the spectrum is. */
void ty_spectrum_light(ty_spectrum spectrum, double rgb[3]);
/* Its mean, weighted by y(lambda). */
double ty_spectrum_mean(ty_spectrum spectrum);
/* Colour of a reflectance, or of a coefficient, in light of D65: a constant spectrum is grey. */
void ty_spectrum_reflectance(ty_spectrum spectrum, double rgb[3]);

/* Colour of a black body, of the luminance 1. */
void ty_blackbody_colour(double kelvin, double rgb[3]);
/* Luminance of a black body whose largest spectral radiance is 1 per nm: the integral of y(lambda) L(lambda). */
double ty_normalized_blackbody_luminance(double kelvin);

/* Converts a colour of a colour space ("srgb", "rec2020", "dci-p3", "aces2065-1"); false for others. */
bool ty_colour_from_space(const char* space, double rgb[3]);

/* Index of refraction of a named glass; false for other names. */
bool ty_named_ior(const char* name, double* ior);
/* Index and absorption of a named metal ("Au") at 650, 550 and 450 nm; false for other names. */
bool ty_named_metal(const char* name, double eta[3], double k[3]);
/* Reflectance at normal incidence of a conductor. */
double ty_conductor_reflectance(double eta, double k);
/* Colour of a named illuminant ("stdillum-D65"), of the luminance 1; false for other names. */
bool ty_named_illuminant(const char* name, double rgb[3]);

#endif
