/* Published phase functions of particles: a fit for droplets, and particles in water. */
#ifndef TY_SCENE_MEDIA_PHASE_FIT_H
#define TY_SCENE_MEDIA_PHASE_FIT_H

/* Droplets of fog and clouds (Jendersie and d'Eon 2023): the Henyey-Greenstein lobe `g`, and of weight `draine_weight`
 * the Draine lobe (draine_g, alpha). diameter: micrometres, up to 50. */
typedef struct ty_mie_fit {
    double g, draine_g, alpha, draine_weight;
} ty_mie_fit;

ty_mie_fit ty_mie_fit_of(double diameter);

/* The phase function of particles of relative refractive index n whose radii r have the distribution r^-slope, 1/sr, at
 * 1 - mu in (0, 2]; and the fraction of light that it scatters back. */
double ty_fournier_forand(double n, double slope, double one_minus_mu);
double ty_fournier_forand_backscatter(double n, double slope);

/* The index that goes with a slope in natural water, and the slope of such a pair that scatters a fraction back
 * (Mobley, Sundman and Boss 2002). */
double ty_fournier_forand_index(double slope);
double ty_fournier_forand_slope(double backscatter);

#endif
