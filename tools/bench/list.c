/* The list of benches. */
#include "bench/list.h"

const bench_entry bench_entries[BENCH_COUNT] = {
    {"machine", "peak arithmetic and memory bandwidth of this machine", bench_machine},
    {"path", "noise, time and samples per second of the path tracer over scenes", bench_path},
    {"direct", "light that has not scattered yet, on grids: cells per second", bench_direct},
    {"rays", "rays per second through a mesh, beside a bare loop over Embree", bench_rays},
    {"screen", "screen-space scattering, beside streaming its bytes and its reference", bench_screen},
    {"fld", "flux-limited diffusion: its solvers, and images beside path", bench_fld},
    {"pop", "principal-ordinates propagation: its stages, and their scaling", bench_pop},
    {"lpv", "light propagation volumes: stages as in the paper's Table 1, growth, a frame", bench_lpv},
    {"dom", "discrete ordinates: solves, sweeps against thickness, images beside path", bench_dom},
    {"octaves", "multiple-scattering octaves: images by their number and from froxels, beside path", bench_octaves},
    {"gradient", "gradients by fld and dom, in solves", bench_gradient},
    {"denoise", "denoising of path-traced images, in parts and at once", bench_denoise},
    {"impulse", "tables of impulse responses: making, reading, looking up", bench_impulse},
    {"bake", "baking: overhead of radiance caches and impulse responses, and speedup over paths", bench_bake},
    {"view", "the live viewer: latency and frame rate, seen by a headless client", bench_view},
    {"load", "reading volumes of every format", bench_load},
    {"device",
     "a GPU beside the processor: path, marching, screen, sweeps, and whether it gives the bits of its host twin",
     bench_device},
    {"edit", "changes of a scene that is shown, beside loading it", bench_edit},
};
