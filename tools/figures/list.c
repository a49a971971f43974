/* The list of figures. */
#include "figures/list.h"

const figure_paper figure_papers[FIGURE_PAPERS] = {
    [FIGURE_SCREEN] = {"Screen-space scattering",
                       "Elek, Ritschel, Seidel: Real-Time Screen-Space Scattering in Homogeneous Environments (2013)"},
    [FIGURE_FLD] = {"Flux-limited diffusion",
                    "Koerner, Portsmouth, Sadlo, Ertl, Eberhardt: Flux-Limited Diffusion for Multiple Scattering in "
                    "Participating Media (2014)"},
    [FIGURE_POP] = {"Principal-ordinates propagation",
                    "Elek, Ritschel, Dachsbacher, Seidel: Principal-Ordinates Propagation for Real-Time Rendering of "
                    "Participating Media (2014)"},
    [FIGURE_LPV] = {"Light propagation volumes",
                    "Billeter, Sintorn, Assarsson: Real-Time Multiple Scattering using Light Propagation Volumes "
                    "(2012)"},
    [FIGURE_IMPULSE] = {"Impulse responses", "Dubouchet, Sloan, Jarosz, Nowrouzezahrai: Impulse Responses for "
                                             "Precomputing Light from Volumetric Media (2019)"},
    [FIGURE_DOM] = {"Discrete ordinates", ""},
    [FIGURE_AUTO] = {"Method auto", ""},
    [FIGURE_PATH] = {"Path tracing", ""},
    [FIGURE_I3RC] =
        {"Intercomparison of 3D radiation codes",
         "Cahalan et al.: The I3RC: Bringing Together the Most Advanced Radiative Transfer Tools for Cloudy "
         "Atmospheres (2005)"},
    [FIGURE_SCALING] =
        {"Many ranks", "Koch, Baker, Alcouffe: Solution of the First-Order Form of the 3-D Discrete Ordinates Equation "
                       "on a Massively Parallel Processor (1992)"},
    [FIGURE_MATRIX] = {"Methods by scenes", ""},
};

#define FIGURE_ENTRY(method, subject, paper, number, title)                                                            \
    {#method "-" #subject, FIGURE_##paper, number, title, figure_##method##_##subject},
const figure_entry figure_entries[] = {FIGURES(FIGURE_ENTRY)};

const int figure_entry_count = sizeof figure_entries / sizeof figure_entries[0];

void figure_full_title(const figure_entry* entry, char out[FIGURE_TITLE_SIZE]) {
    const bool numbered = entry->number[0] != '\0';
    snprintf(out, FIGURE_TITLE_SIZE, "%s: %s%s%s%s", figure_papers[entry->paper].method, entry->title,
             numbered ? " (" : "", entry->number, numbered ? ")" : "");
}
