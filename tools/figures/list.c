/* The figures that there are. */
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
};

const figure_entry figure_entries[] = {
    {"screen-spread", FIGURE_SCREEN, "Fig. 4", "how wide light spreads with distance", figure_screen_spread},
    {"screen-stages", FIGURE_SCREEN, "Figs. 1, 5", "what goes in, what the steps make of it, what comes out",
     figure_screen_stages},
    {"screen-leaking", FIGURE_SCREEN, "Fig. 6", "what keeps light from leaking", figure_screen_leaking},
    {"screen-thickness", FIGURE_SCREEN, "Fig. 7", "optical thickness 2 to 8", figure_screen_thickness},
    {"screen-truth", FIGURE_SCREEN, "Fig. 8", "against path tracing", figure_screen_truth},
    {"screen-photo", FIGURE_SCREEN, "Fig. 9", "a photograph in three media", figure_screen_photo},
    {"screen-table", FIGURE_SCREEN, "Table 1", "milliseconds", figure_screen_table},
    {"fld-limiters", FIGURE_FLD, "Table 2", "flux limiters", figure_fld_limiters},
    {"fld-point", FIGURE_FLD, "Figs. 3, 5", "a point source, theory and solvers", figure_fld_point},
    {"fld-convergence", FIGURE_FLD, "Fig. 4", "how fast solvers converge", figure_fld_convergence},
    {"fld-nebulae", FIGURE_FLD, "Fig. 1", "a nebula in vacuum", figure_fld_nebulae},
    {"fld-resolution", FIGURE_FLD, "Fig. 6", "full against quarter resolution", figure_fld_resolution},
    {"fld-albedo", FIGURE_FLD, "Fig. 7", "albedo 0.1 to 1", figure_fld_albedo},
    {"fld-ct", FIGURE_FLD, "Fig. 8", "a CT scan with a transfer function", figure_fld_ct},
    {"fld-fire", FIGURE_FLD, "Fig. 9", "a plume that glows", figure_fld_fire},
    {"pop-prefilter", FIGURE_POP, "Fig. 6", "thin slabs, prefiltered", figure_pop_prefilter},
    {"pop-importance", FIGURE_POP, "Fig. 7", "few ordinates, where they count", figure_pop_importance},
    {"pop-residuum", FIGURE_POP, "Fig. 8", "isotropic light in one grid", figure_pop_residuum},
    {"pop-sphere", FIGURE_POP, "Fig. 10", "a point light in a sphere", figure_pop_sphere},
    {"pop-smoke", FIGURE_POP, "Fig. 11", "smoke in an environment", figure_pop_smoke},
    {"pop-lobes", FIGURE_POP, "Fig. 12", "where light goes in a cube", figure_pop_lobes},
    {"pop-iterations", FIGURE_POP, "Fig. 13", "how the propagation converges", figure_pop_iterations},
    {"pop-ordinates", FIGURE_POP, "Fig. 14", "numbers of ordinates and importance", figure_pop_ordinates},
    {"pop-clouds", FIGURE_POP, "Fig. 15", "clouds, anisotropic and not", figure_pop_clouds},
    {"pop-animation", FIGURE_POP, "Fig. 16", "a plume, frame by frame", figure_pop_animation},
    {"pop-surfaces", FIGURE_POP, "Fig. 17", "a solid in a medium", figure_pop_surfaces},
    {"pop-table", FIGURE_POP, "Fig. 14", "milliseconds of the typical setting", figure_pop_table},
    {"lpv-parts", FIGURE_LPV, "Fig. 5", "what each part adds", figure_lpv_parts},
    {"lpv-leaking", FIGURE_LPV, "Fig. 6", "thin walls, small lights, few iterations", figure_lpv_leaking},
    {"lpv-truth", FIGURE_LPV, "Figs. 7, 8", "against path tracing", figure_lpv_truth},
    {"lpv-shafts", FIGURE_LPV, "", "single scattering against path tracing", figure_lpv_shafts},
    {"lpv-animation", FIGURE_LPV, "", "sun and camera in small steps", figure_lpv_animation},
    {"lpv-energy", FIGURE_LPV, "", "where the energy goes", figure_lpv_energy},
    {"lpv-dense", FIGURE_LPV, "", "thin to dense fog around a lamp", figure_lpv_dense},
    {"lpv-table", FIGURE_LPV, "Table 1", "milliseconds of injection and propagation", figure_lpv_table},
    {"impulse-tables", FIGURE_IMPULSE, "Fig. 10", "zonal harmonics over distance", figure_impulse_tables},
    {"bake-staircase", FIGURE_IMPULSE, "Fig. 8", "by vertex, media that vary", figure_bake_staircase},
    {"bake-cornell", FIGURE_IMPULSE, "Fig. 9", "lightmaps in fog, back-scattering", figure_bake_cornell},
    {"bake-lights", FIGURE_IMPULSE, "Fig. 12", "a lamp and the sun in fog", figure_bake_lights},
    {"bake-table", FIGURE_IMPULSE, "Section 5", "what light from media costs on top of surfaces", figure_bake_table},
    {"dom-cube", FIGURE_DOM, "", "fluence of a cube in a beam", figure_dom_cube},
    {"dom-convergence", FIGURE_DOM, "", "sweeps against thickness, with diffusion's help and without",
     figure_dom_convergence},
    {"dom-rays", FIGURE_DOM, "", "ray effects and false scattering", figure_dom_rays},
    {"dom-images", FIGURE_DOM, "", "images beside those of other methods", figure_dom_images},
    {"auto-choice", FIGURE_AUTO, "", "what its choices cost against the best in their time", figure_auto_choice},
};

const int figure_entry_count = sizeof figure_entries / sizeof figure_entries[0];

void figure_full_title(const figure_entry* entry, char out[FIGURE_TITLE_SIZE]) {
    const bool numbered = entry->number[0] != '\0';
    snprintf(out, FIGURE_TITLE_SIZE, "%s: %s%s%s%s", figure_papers[entry->paper].method, entry->title,
             numbered ? " (" : "", entry->number, numbered ? ")" : "");
}
