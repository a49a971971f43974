/* Lattices of light: links, steps, energy, surfaces, diffusion, nesting, lookups. */
#include "ledger.h"

#include "method/lpv/lattice/lookup.k.h"
#include "method/lpv/propagate/propagate.h"
#include "method/lpv/propagate/transfer.h"

static const double power_of_term = 3.5449077018110321; /* sqrt(4 pi) */

static ty_lattice* make_lattice(ty_context* context, int32_t x, int32_t y, int32_t z, int32_t bands) {
    const ty_grid_box box = {.upper = {0.5 * x, 0.5 * y, 0.5 * z}, .size = {x, y, z}};
    ty_lattice* lattice = NULL;
    assert_int_equal(ty_lattice_create(context, &box, bands, &lattice), TY_OK);
    return lattice;
}

static size_t cell_at(const ty_lattice* lattice, int32_t x, int32_t y, int32_t z) {
    const int32_t* size = lattice->box.size;
    return (size_t)((z * size[1] + y) * size[0] + x);
}

/* The same medium everywhere, or twice as dense where x is odd. */
static void set_medium(ty_lattice* lattice, double sigma_s, double sigma_a, double g, bool uneven) {
    ty_scene* scene = make_scene(lattice->context);
    ty_medium_def def = box_medium(lattice->box.lower, lattice->box.upper, (float)sigma_s, (float)sigma_a);
    for (int c = 0; c < 3; ++c) def.g[c] = (float)g;
    assert_int_equal(ty_scene_add_medium(scene, &def), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    assert_int_equal(ty_grid_medium_create(scene, &lattice->box, &lattice->medium), TY_OK);
    for (size_t i = 1; i < lattice->cells && uneven; i += 2) {
        lattice->medium->extinction[0][i] *= 2;
        lattice->medium->scattering[0][i] *= 2;
    }
    ty_scene_destroy(scene);
}

static void inject_random(ty_lattice* lattice, uint64_t seed) {
    for (int c = 0; c < 3; ++c)
        for (size_t i = 0; i < lattice->cells; ++i) {
            const double power = uniform(&seed);
            float y[TY_SH_TERMS];
            ty_sh_at(random_unit(&seed), lattice->bands, y);
            for (int32_t t = 0; t < lattice->terms; ++t)
                lattice->propagated_sh[c][t][i] = (float)power * y[t] * ty_sh_cosine(ty_sh_band(t)) / TY_PI;
        }
}

/* Closes links at random, both ways alike. */
static void close_random(ty_lattice* lattice, uint64_t seed, double share) {
    const int32_t* size = lattice->box.size;
    for (int32_t place = 0; place < 13; ++place) {
        const int32_t e[3] = {place % 3 - 1, place / 3 % 3 - 1, place / 9 - 1};
        const int32_t k = ty_lpv_link(e[0], e[1], e[2]), back = ty_lpv_link(-e[0], -e[1], -e[2]);
        for (int32_t z = 0; z < size[2]; ++z)
            for (int32_t y = 0; y < size[1]; ++y)
                for (int32_t x = 0; x < size[0]; ++x) {
                    const int32_t from[3] = {x - e[0], y - e[1], z - e[2]};
                    if (uniform(&seed) > share) continue;
                    const uint8_t transmission = (uint8_t)(255 * uniform(&seed));
                    lattice->transmission[k][cell_at(lattice, x, y, z)] = transmission;
                    if (from[0] >= 0 && from[0] < size[0] && from[1] >= 0 && from[1] < size[1] && from[2] >= 0 &&
                        from[2] < size[2])
                        lattice->transmission[back][cell_at(lattice, from[0], from[1], from[2])] = transmission;
                }
    }
    for (int c = 0; c < 3; ++c)
        for (size_t i = 0; i < lattice->cells; ++i) lattice->albedo[c][i] = (float)uniform(&seed);
    lattice->blocked = true;
}

static ty_lpv_def make_def(ty_lpv_mode mode, int32_t iterations) {
    return (ty_lpv_def){.mode = mode, .iterations = iterations, .tolerance = 0.01};
}

static ty_lattice_power propagate(ty_lattice* lattice, ty_lpv_mode mode, int32_t iterations, const ty_lattice* outer) {
    const ty_lpv_def def = make_def(mode, iterations);
    ty_lattice_power power;
    assert_int_equal(ty_lattice_propagate(lattice, &def, NULL, outer, NULL, NULL, &power), TY_OK);
    return power;
}

/* ---- links ---- */

static void links_share_all_light(void** state) {
    (void)state;
    for (int32_t bands = 2; bands <= 3; ++bands)
        for (int keeps = 0; keeps < 2; ++keeps) {
            ty_lpv_transfer transfer;
            ty_lpv_transfer_make(bands, keeps != 0, &transfer);
            double products[TY_SH_TERMS][TY_SH_TERMS] = {{0}};
            for (int32_t k = 0; k < TY_LPV_LINKS; ++k)
                for (int32_t i = 0; i < 9; ++i)
                    for (int32_t j = 0; j < 9; ++j) products[i][j] += (double)(transfer.G[k][i] * transfer.G[k][j]);
            assert_close(products[0][0], 1, 1e-6);
            for (int32_t i = 0; i < bands * bands; ++i)
                for (int32_t j = 0; j < bands * bands; ++j) {
                    if (i != j) assert_close(products[i][j], 0, 1e-6);
                    if (i == j) assert_true(products[i][i] <= 1 + 1e-6);
                }
            assert_close(products[1][1], transfer.momentum, 1e-6);
            assert_true(keeps == 0 || fabs(transfer.momentum - 1) < 1e-6);
            for (int32_t k = 0; k < 13; ++k)
                for (int a = 0; a < 3; ++a) assert_int_equal(transfer.step[k][a], -transfer.step[k + 13][a]);
        }
}

/* The integral over a link's patch of the sphere of Y_t, and its solid angle. A patch holds the directions that are
 * nearest to the link by multiples of 45 degrees, component by component; here of a fine net of polar angles, which
 * knows nothing of the library's cube. */
typedef struct patch_integrals {
    double solid_angle, terms[9];
} patch_integrals;

static void integrate_patches(patch_integrals patches[27]) {
    enum { RINGS = 400, STEPS = 800 };
    const double tangent = sqrt(2) - 1; /* of 22.5 degrees */
    memset(patches, 0, 27 * sizeof *patches);
    for (int i = 0; i < RINGS; ++i)
        for (int k = 0; k < STEPS; ++k) {
            const double z = (2 * i + 1.0) / RINGS - 1, angle = 2 * 3.14159265358979 * (k + 0.5) / STEPS;
            const double radius = sqrt(1 - z * z), weight = 4 * 3.14159265358979 / (RINGS * STEPS);
            const double p[3] = {radius * cos(angle), radius * sin(angle), z};
            const double longest = fmax(fabs(p[0]), fmax(fabs(p[1]), fabs(p[2])));
            int place = 0;
            for (int a = 2; a >= 0; --a)
                place = 3 * place + (p[a] > tangent * longest ? 2 : p[a] < -tangent * longest ? 0 : 1);
            float y[TY_SH_TERMS];
            ty_sh_at(ty_vec_make((float)p[0], (float)p[1], (float)p[2]), 3, y);
            patches[place].solid_angle += weight;
            for (int t = 0; t < 9; ++t) patches[place].terms[t] += weight * (double)y[t];
        }
}

/* Shapes are projections of patches that cover the sphere, over the root of the patch's solid angle, so that the
 * squares of the constant term add up to 1. The mean length of a link is that of its patch's weight, (A + sqrt(2) B +
 * sqrt(3) C) / (4 pi) of the solid angles A, B, C of all faces, edges and corners. */
static void shapes_point_along_links(void** state) {
    (void)state;
    static patch_integrals patches[27];
    ty_lpv_transfer transfer;
    ty_lpv_transfer_make(3, false, &transfer);
    integrate_patches(patches);
    double length = 0;
    for (int32_t k = 0; k < TY_LPV_LINKS; ++k) {
        const int32_t* e = transfer.step[k];
        const float* transfer_G = transfer.G[k];
        float y[TY_SH_TERMS];
        ty_sh_at(ty_normalize(ty_vec_make((float)e[0], (float)e[1], (float)e[2])), 3, y);
        double along = 0, size = 0;
        for (int t = 0; t < 9; ++t) {
            along += (double)(transfer_G[t] * y[t]);
            size += (double)(transfer_G[t] * transfer_G[t]);
        }
        const double most = 9 / (4 * 3.14159265);
        assert_true(along > 0.97 * sqrt(size * most) && along <= sqrt(size * most));
        const patch_integrals* patch = &patches[(e[2] + 1) * 9 + (e[1] + 1) * 3 + e[0] + 1];
        for (int t = 0; t < 9; ++t) assert_close(transfer_G[t], patch->terms[t] / sqrt(patch->solid_angle), 2e-3);
        length += patch->solid_angle * sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2]) / (4 * 3.14159265358979);
    }
    assert_close(transfer.length, length, 4e-3); /* the library's net has 48 points along the side of a face */
}

/* Plane waves in vacuum never grow: with momentum kept in full nothing could be lost, and nothing is gained. */
static void waves_do_not_grow(void** state) {
    (void)state;
    uint64_t seed = 5;
    for (int32_t bands = 2; bands <= 3; ++bands) {
        ty_lpv_transfer transfer;
        ty_lpv_transfer_make(bands, true, &transfer);
        for (int wave = 0; wave < 200; ++wave) {
            double k[3], re[9], im[9], first = 0, most = 0;
            for (int a = 0; a < 3; ++a) k[a] = uniform_in(&seed, -3.14159265, 3.14159265);
            for (int t = 0; t < transfer.terms; ++t) {
                re[t] = uniform_in(&seed, -1, 1);
                im[t] = uniform_in(&seed, -1, 1);
                first += re[t] * re[t] + im[t] * im[t];
            }
            for (int n = 0; n < 200; ++n) {
                double r[9] = {0}, i[9] = {0}, size = 0;
                for (int32_t j = 0; j < TY_LPV_LINKS; ++j) {
                    const float* transfer_G = transfer.G[j];
                    const int32_t* e = transfer.step[j];
                    const double turn = -(k[0] * e[0] + k[1] * e[1] + k[2] * e[2]);
                    double x = 0, y = 0;
                    for (int t = 0; t < transfer.terms; ++t) {
                        x += re[t] * (double)transfer_G[t];
                        y += im[t] * (double)transfer_G[t];
                    }
                    for (int t = 0; t < transfer.terms; ++t) {
                        r[t] += (double)transfer_G[t] * (x * cos(turn) - y * sin(turn));
                        i[t] += (double)transfer_G[t] * (x * sin(turn) + y * cos(turn));
                    }
                }
                memcpy(re, r, sizeof r);
                memcpy(im, i, sizeof i);
                for (int t = 0; t < transfer.terms; ++t) size += re[t] * re[t] + im[t] * im[t];
                most = fmax(most, size);
            }
            assert_true(most <= first * (1 + 1e-4));
        }
    }
}

/* ---- media ---- */

static void steps_keep_what_is_not_absorbed(void** state) {
    (void)state;
    ty_lpv_transfer transfer;
    ty_lpv_transfer_make(2, true, &transfer);
    for (int m = 0; m < 2; ++m)
        for (double sigma = 0; sigma < 2000; sigma = sigma * 1.7 + 0.001)
            for (double albedo = 0; albedo <= 1; albedo += 0.25)
                for (double g = -0.9; g < 1; g += 0.3) {
                    const ty_lpv_cell_medium medium = {(float)sigma, (float)(albedo * sigma), (float)g,
                                                       sigma < 10 ? 0 : 0.5f};
                    const ty_lpv_medium_step step = ty_lpv_step_in(&transfer, (ty_lpv_mode)m, 0.7f, &medium);
                    const double taken = sigma * (1 - albedo) * (double)step.length;
                    assert_close(step.scatter_factor[0], 1 - taken, 2e-5);
                    assert_true(step.scatter_factor[0] >= 0 && step.scatter_factor[0] <= 1);
                    assert_true(fabsf(step.scatter_factor[1]) <= step.scatter_factor[0] + 2e-6f &&
                                fabsf(step.scatter_factor[2]) <= 1.0f);
                    assert_true(step.length > 0 && step.injected_fraction[0] >= 0.5f &&
                                step.injected_fraction[0] <= 1 && step.injected_fraction[1] >= 0);
                    assert_true(step.flux_factor[1] > 0 && step.flux_factor[1] < 2000);
                    if (m == 0) assert_true(step.scatter_factor[1] >= 0);
                }
    const ty_lpv_cell_medium nothing = {.g = 0}, little = {1e-4f, 1e-4f, 0, 0}, by_lamp = {.extinction_floor = 0.5f};
    const ty_lpv_medium_step vacuum = ty_lpv_step_in(&transfer, TY_LPV_MODE_LINKS, 0.7f, &nothing);
    const ty_lpv_medium_step thin = ty_lpv_step_in(&transfer, TY_LPV_MODE_LINKS, 0.7f, &little);
    const ty_lpv_medium_step about = ty_lpv_step_in(&transfer, TY_LPV_MODE_LINKS, 0.7f, &by_lamp);
    assert_close(vacuum.length, 0.7 * transfer.length, 1e-6);
    assert_close(thin.length, vacuum.length, 1e-3);
    assert_close(thin.scatter_factor[1], vacuum.scatter_factor[1], 1e-3);
    assert_close(thin.flux_factor[1], vacuum.flux_factor[1], 1e-3);
    assert_close(vacuum.flux_factor[1], 1, 0.06);
    assert_true(about.scatter_factor[0] == vacuum.scatter_factor[0] &&
                about.scatter_factor[1] < 0.8f * vacuum.scatter_factor[1]);
}

/* ---- energy ---- */

/* No absorption: what is in the lattice and what went out is what came in, after each of eight iterations. */
static void check_conserved(ty_context* context, ty_lpv_mode mode, int32_t bands, double depth, bool uneven) {
    for (int32_t n = 1; n <= 8; ++n) {
        ty_lattice* lattice = make_lattice(context, 12, 7, 9, bands);
        ty_lpv_transfer transfer;
        ty_lpv_transfer_make(bands, true, &transfer);
        if (depth > 0) set_medium(lattice, depth / (transfer.length * (double)lattice->cell), 0, 0.3, uneven);
        inject_random(lattice, 3);
        const ty_lattice_power power = propagate(lattice, mode, n, NULL);
        assert_int_equal(power.iterations, n);
        for (int c = 0; c < 3; ++c) {
            assert_true(power.entered[c] > 0 && power.escaped[c] > 0);
            assert_close(power.left[c] + power.escaped[c], power.entered[c], 1e-4 * power.entered[c]);
            assert_close(power.absorbed[c], 0, 1e-4 * power.entered[c]);
        }
        ty_lattice_destroy(lattice);
    }
}

static void energy_is_kept(void** state) {
    for (int m = 0; m < 2; ++m)
        for (int32_t bands = 2; bands <= 3; ++bands)
            for (double depth = 0; depth <= 10; depth = depth * 3 + 0.1)
                check_conserved(*state, (ty_lpv_mode)m, bands, depth, depth > 1);
}

/* Light that goes on and light that is scattered into it, apart: without scattering e^-depth of it goes on, and
 * scattering brings the rest. */
static void scattering_brings_what_extinction_takes(void** state) {
    for (double depth = 0.05; depth <= 10; depth *= 2) {
        double goes_on[2];
        for (int albedo = 0; albedo < 2; ++albedo) {
            ty_lattice* lattice = make_lattice(*state, 8, 8, 8, 2);
            ty_lpv_transfer transfer;
            ty_lpv_transfer_make(2, false, &transfer);
            const double sigma = depth / (transfer.length * (double)lattice->cell);
            set_medium(lattice, albedo * sigma, (1 - albedo) * sigma, 0, false);
            inject_random(lattice, 9);
            const ty_lattice_power power = propagate(lattice, TY_LPV_MODE_PUBLISHED, 1, NULL);
            goes_on[albedo] = (power.left[0] + power.escaped[0]) / power.entered[0];
            assert_close(goes_on[albedo] + power.absorbed[0] / power.entered[0], 1, 1e-4);
            ty_lattice_destroy(lattice);
        }
        assert_close(goes_on[0], exp(-depth), 1e-4);
        assert_close(goes_on[1] - goes_on[0], 1 - exp(-depth), 2e-4);
    }
}

static void books_balance_among_surfaces(void** state) {
    for (int m = 0; m < 2; ++m)
        for (int32_t bands = 2; bands <= 3; ++bands)
            for (int fog = 0; fog < 2; ++fog) {
                ty_lattice* lattice = make_lattice(*state, 21, 6, 7, bands);
                if (fog != 0) set_medium(lattice, 0.4, 0.2, 0.5, true);
                close_random(lattice, 11, 0.3);
                inject_random(lattice, 12);
                const ty_lattice_power power = propagate(lattice, (ty_lpv_mode)m, 12, NULL);
                for (int c = 0; c < 3; ++c) {
                    const double all = power.absorbed[c] + power.blocked[c] + power.escaped[c] + power.left[c];
                    assert_close(all, power.entered[c], 1e-4 * power.entered[c]);
                    assert_true(power.blocked[c] > 0.1 * power.entered[c]);
                    assert_true((power.absorbed[c] > 0.05 * power.entered[c]) == (fog != 0));
                }
                ty_lattice_destroy(lattice);
            }
}

/* A closed box with white walls keeps its light; with grey ones they take all. */
static void closed_rooms_keep_light(void** state) {
    for (int white = 0; white < 2; ++white) {
        ty_lattice* lattice = make_lattice(*state, 6, 5, 1, 2);
        for (int32_t k = 0; k < TY_LPV_LINKS; ++k) {
            ty_lpv_transfer transfer;
            ty_lpv_transfer_make(2, true, &transfer);
            const int32_t* e = transfer.step[k];
            for (int32_t y = 0; y < 5; ++y)
                for (int32_t x = 0; x < 6; ++x)
                    if (x - e[0] < 0 || x - e[0] >= 6 || y - e[1] < 0 || y - e[1] >= 5 || e[2] != 0)
                        lattice->transmission[k][cell_at(lattice, x, y, 0)] = 0;
        }
        lattice->blocked = true;
        for (int c = 0; c < 3; ++c)
            for (size_t i = 0; i < lattice->cells; ++i) lattice->albedo[c][i] = white != 0 ? 1.0f : 0.5f;
        inject_random(lattice, 21);
        const ty_lattice_power power = propagate(lattice, TY_LPV_MODE_LINKS, white != 0 ? 60 : 0, NULL);
        for (int c = 0; c < 3; ++c) {
            assert_close(power.escaped[c], 0, 1e-5 * power.entered[c]);
            if (white != 0) assert_close(power.left[c], power.entered[c], 1e-4 * power.entered[c]);
            if (white == 0) assert_close(power.blocked[c], power.entered[c], 0.011 * power.entered[c]);
        }
        ty_lattice_destroy(lattice);
    }
}

/* ---- diffusion ---- */

/* A lamp in the middle of a cube of a medium without absorption, against 1 / (4 pi D r) less what it is at the faces:
 * differences between two distances. */
static void check_diffusion(ty_context* context, double depth, double g, double tolerance) {
    const int32_t n = 25, m = 12;
    ty_lattice* lattice = make_lattice(context, n, n, n, 2);
    const double cell = (double)lattice->cell, sigma = depth / cell / (1 - g);
    set_medium(lattice, sigma, 0, g, false);
    for (int c = 0; c < 3; ++c) lattice->propagated_sh[c][0][cell_at(lattice, m, m, m)] = (float)(1 / power_of_term);
    const ty_lpv_def def = {.mode = TY_LPV_MODE_LINKS, .tolerance = 1e-3};
    ty_lattice_power power;
    assert_int_equal(ty_lattice_propagate(lattice, &def, NULL, NULL, NULL, NULL, &power), TY_OK);
    const float* even = lattice->light[1][0];
    const double near = power_of_term * (double)even[cell_at(lattice, m + 4, m, m)];
    const double far = power_of_term * (double)even[cell_at(lattice, m + 8, m, m)];
    const double d = 1 / (3 * depth / cell), expected = (1 / 4.0 - 1 / 8.0) / (4 * 3.14159265 * d * cell);
    assert_close((near - far) / expected, 1, tolerance);
    ty_lattice_destroy(lattice);
}

static void lattices_diffuse_as_media_do(void** state) {
    check_diffusion(*state, 0.5, 0, 0.08); /* two free paths from the lamp */
    check_diffusion(*state, 0.8, 0.6, 0.05);
    check_diffusion(*state, 0.9, 0, 0.05);
    check_diffusion(*state, 8, -0.4, 0.05);
}

/* ---- lamps ---- */

/* Fluence at a few cells from light that is injected in the middle of a vacuum, times 4 pi r^2 over its power. */
static void thin_out(ty_context* context, const ty_light_view* lights, int32_t count, double shares[3]) {
    static const int32_t apart[3] = {3, 6, 10};
    const int32_t n = 33, m = 16;
    ty_lattice* lattice = make_lattice(context, n, n, n, 2);
    const double cell = (double)lattice->cell;
    assert_int_equal(ty_lattice_find_extinction_floor(lattice, lights, count), TY_OK);
    for (int c = 0; c < 3; ++c) lattice->propagated_sh[c][0][cell_at(lattice, m, m, m)] = (float)(1 / power_of_term);
    propagate(lattice, TY_LPV_MODE_LINKS, 0, NULL);
    for (int i = 0; i < 3; ++i) {
        const double fluence = power_of_term * (double)lattice->light[1][0][cell_at(lattice, m + apart[i], m, m)];
        shares[i] = fluence * 4 * 3.14159265 * pow(cell * apart[i], 2);
    }
    ty_lattice_destroy(lattice);
}

static void lamps_light_thins_out(void** state) {
    const float middle = 0.5f * 16.5f;
    const ty_light_view lamp = {.kind = TY_KIND_POINT, .color = {1, 1, 1}, .position = {middle, middle, middle}};
    const ty_light_view sun = {.kind = TY_KIND_DIRECTIONAL, .color = {1e6f, 1e6f, 1e6f}, .direction = {0, -1, 0}};
    const ty_light_view both[2] = {sun, lamp};
    double alone[3], beside[3], none[3];
    thin_out(*state, &lamp, 1, alone);
    thin_out(*state, both, 2, beside);
    thin_out(*state, &sun, 1, none);
    for (int i = 0; i < 3; ++i) {
        assert_close(alone[i], 1.15, 0.25);
        assert_close(beside[i], none[i], 0.01 * none[i]);
    }
    assert_true(none[0] < 0.5 * alone[0]);
}

/* ---- the rest of what propagation promises ---- */

static void threads_do_not_matter(void** state) {
    (void)state;
    float* first = NULL;
    for (int32_t threads = 1; threads <= 3; ++threads) {
        ty_context* context = make_context(threads);
        ty_lattice* lattice = make_lattice(context, 17, 9, 11, 2);
        set_medium(lattice, 0.3, 0.1, 0.2, true);
        close_random(lattice, 4, 0.2);
        inject_random(lattice, 5);
        propagate(lattice, TY_LPV_MODE_LINKS, 0, NULL);
        if (first == NULL) {
            first = malloc(lattice->cells * sizeof *first);
            memcpy(first, lattice->light[1][2], lattice->cells * sizeof *first);
        }
        assert_memory_equal(first, lattice->light[1][2], lattice->cells * sizeof *first);
        ty_lattice_destroy(lattice);
        ty_context_destroy(context);
    }
    free(first);
}

static bool refuse(void* user, const ty_progress* progress) {
    assert_string_equal(progress->stage, "propagation");
    ++*(int*)user;
    return false;
}

static void propagation_can_be_cancelled(void** state) {
    ty_lattice* lattice = make_lattice(*state, 8, 8, 8, 2);
    const ty_lpv_def def = make_def(TY_LPV_MODE_LINKS, 4);
    ty_lattice_power power;
    int calls = 0;
    assert_int_equal(ty_lattice_propagate(lattice, &def, NULL, NULL, refuse, &calls, &power), TY_CANCELLED);
    assert_int_equal(calls, 1);
    ty_lattice_destroy(lattice);
}

static ty_result work_small(ty_context* context) {
    ty_lattice* lattice = NULL;
    ty_result result = ty_lattice_create_sample(context, 6, 2, true, &lattice);
    const ty_lpv_def def = make_def(TY_LPV_MODE_LINKS, 2);
    ty_lattice_power power;
    if (result == TY_OK) result = ty_lattice_propagate(lattice, &def, NULL, NULL, NULL, NULL, &power);
    ty_lattice_destroy(lattice);
    return result;
}

static void memory_is_given_back(void** state) {
    (void)state;
    check_failed_allocations(work_small);
}

static void seen_light_counts_where_it_is(void** state) {
    for (int seen_part = 0; seen_part < 2; ++seen_part) {
        ty_lattice* lattice = make_lattice(*state, 5, 5, 5, 2);
        const size_t middle = cell_at(lattice, 2, 2, 2);
        ty_lpv_transfer transfer;
        ty_lpv_transfer_make(2, false, &transfer);
        float* part = calloc(lattice->cells, sizeof *part);
        float* seen[3][TY_SH_TERMS] = {{part}, {part}, {part}};
        for (int c = 0; c < 3; ++c) lattice->propagated_sh[c][0][middle] = 4;
        part[middle] = (float)seen_part;
        const ty_lpv_def def = make_def(TY_LPV_MODE_PUBLISHED, 1);
        ty_lattice_power power;
        assert_int_equal(ty_lattice_propagate(lattice, &def, seen, NULL, NULL, NULL, &power), TY_OK);
        const double scale = transfer.length * (double)lattice->cell / pow((double)lattice->cell, 3);
        assert_close(lattice->light[0][0][middle], seen_part * scale, 1e-4);
        assert_close(lattice->propagated_sh[0][0][middle], (4 - seen_part) * scale, 1e-4);
        free(part);
        ty_lattice_destroy(lattice);
    }
}

/* ---- nesting ---- */

/* All light is injected far outside of the inner lattice: within it the inner one must be as the outer one, which has
 * cells of the same size here. */
static void light_comes_in_through_faces(void** state) {
    ty_lattice* outer = make_lattice(*state, 24, 20, 20, 2);
    set_medium(outer, 0.3, 0.02, 0, false);
    for (int c = 0; c < 3; ++c) outer->propagated_sh[c][0][cell_at(outer, 3, 10, 10)] = 1;
    for (int c = 0; c < 3; ++c) outer->propagated_sh[c][0][cell_at(outer, 13, 10, 9)] = 0.5f; /* and within both */
    ty_grid_box box = {.size = {8, 8, 8}};
    for (int a = 0; a < 3; ++a) {
        box.lower[a] = 0.5 * 8;
        box.upper[a] = 0.5 * 16;
    }
    ty_lattice* inner = NULL;
    assert_int_equal(ty_lattice_create(*state, &box, 2, &inner), TY_OK);
    set_medium(inner, 0.3, 0.02, 0, false);
    for (int c = 0; c < 3; ++c) inner->propagated_sh[c][0][cell_at(inner, 5, 2, 1)] = 0.5f;
    const ty_lpv_def def = {.mode = TY_LPV_MODE_LINKS, .tolerance = 1e-5};
    ty_lattice_power power;
    assert_int_equal(ty_lattice_propagate(outer, &def, NULL, NULL, NULL, NULL, &power), TY_OK);
    assert_int_equal(ty_lattice_propagate(inner, &def, NULL, outer, NULL, NULL, &power), TY_OK);
    for (int32_t z = 0; z < 8; ++z)
        for (int32_t y = 0; y < 8; ++y)
            for (int32_t x = 0; x < 8; ++x)
                for (int32_t t = 0; t < 4; ++t) {
                    const double a = (double)inner->light[0][t][cell_at(inner, x, y, z)];
                    const double b = (double)outer->light[0][t][cell_at(outer, x + 8, y + 8, z + 8)];
                    assert_close(a, b, 1e-3 * (double)outer->light[0][0][cell_at(outer, x + 8, y + 8, z + 8)]);
                }
    const double all = power.absorbed[0] + power.blocked[0] + power.escaped[0] + power.left[0];
    assert_close(all, power.entered[0], 1e-4 * power.entered[0]);
    assert_true(power.entered[0] > power_of_term * 0.5);
    ty_lattice_destroy(inner);
    ty_lattice_destroy(outer);
}

/* A finer lattice in the middle of a coarse one, evenly lit from far away: light is the same on both. */
static void finer_lattices_see_what_is_around(void** state) {
    ty_lattice* outer = make_lattice(*state, 20, 20, 20, 2);
    set_medium(outer, 0.8, 0, 0, false);
    for (int c = 0; c < 3; ++c)
        for (size_t i = 0; i < 400; ++i) outer->propagated_sh[c][0][i] = 1;
    ty_grid_box box = {.size = {16, 16, 16}};
    for (int a = 0; a < 3; ++a) {
        box.lower[a] = 0.5 * 6;
        box.upper[a] = 0.5 * 14;
    }
    ty_lattice* inner = NULL;
    assert_int_equal(ty_lattice_create(*state, &box, 2, &inner), TY_OK);
    set_medium(inner, 0.8, 0, 0, false);
    propagate(outer, TY_LPV_MODE_LINKS, 0, NULL);
    propagate(inner, TY_LPV_MODE_LINKS, 0, outer);
    double worst = 0;
    for (int32_t z = 0; z < 8; ++z)
        for (int32_t x = 0; x < 8; ++x) {
            double mean = 0;
            for (int i = 0; i < 8; ++i)
                mean +=
                    (double)inner->light[0][0][cell_at(inner, 2 * x + (i & 1), 8 + (i >> 1 & 1), 2 * z + (i >> 2))] / 8;
            const double there = (double)outer->light[0][0][cell_at(outer, x + 6, 10, z + 6)];
            worst = fmax(worst, fabs(mean / there - 1));
        }
    assert_true(worst < 0.05);
    ty_lattice_destroy(inner);
    ty_lattice_destroy(outer);
}

/* ---- where lattices lie ---- */

static ty_scene* make_room(ty_context* context) {
    ty_scene* scene = make_scene(context);
    const ty_medium_def fog = box_medium((double[3]){-2, 0, -1}, (double[3]){6, 3, 1}, 0.1f, 0);
    assert_int_equal(ty_scene_add_medium(scene, &fog), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    return scene;
}

static void look_from(ty_scene* scene, double x, double y, double z) {
    ty_camera_def camera = ty_default_camera_def();
    set3(camera.position, x, y, z);
    set3(camera.target, x, y, z - 1);
    assert_int_equal(ty_scene_set_camera(scene, &camera), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
}

static void lattices_are_nested(void** state) {
    ty_scene* scene = make_room(*state);
    look_from(scene, 5.9, 1, 0);
    for (int place = 0; place < 2; ++place) {
        ty_lpv_def def = {.place = (ty_lpv_place)place, .resolution = 16, .cascades = 3, .extent = 4};
        ty_grid_box boxes[TY_LPV_CASCADES_MAX];
        int32_t count = 0;
        assert_int_equal(ty_lattice_place(scene, &def, boxes, &count), TY_OK);
        assert_int_equal(count, 3);
        for (int32_t i = 0; i < 3; ++i)
            for (int a = 0; a < 3; ++a) {
                const double cell = (boxes[i].upper[0] - boxes[i].lower[0]) / boxes[i].size[0];
                assert_close(boxes[i].upper[a] - boxes[i].lower[a], cell * boxes[i].size[a], 1e-9);
                if (i == 2) continue;
                const double outer = (boxes[i + 1].upper[0] - boxes[i + 1].lower[0]) / boxes[i + 1].size[0];
                assert_close(outer, 2 * cell, 1e-9);
                assert_true(boxes[i].lower[a] > boxes[i + 1].lower[a] - 1e-9);
                assert_true(boxes[i].upper[a] < boxes[i + 1].upper[a] + 1e-9);
                const double apart = (boxes[i].lower[a] - boxes[i + 1].lower[a]) / cell;
                assert_close(apart, round(apart), 1e-9);
            }
        if (place == 0) {
            assert_true(boxes[2].lower[0] <= -2 && boxes[2].upper[0] >= 6 && boxes[2].upper[1] >= 3);
            assert_int_equal(boxes[2].size[0], 16);
            assert_int_equal(boxes[2].size[1], 6);
            assert_int_equal(boxes[2].size[2], 4);
        } else {
            assert_close(boxes[0].upper[1] - boxes[0].lower[1], 4, 1e-9);
        }
    }
    ty_scene_destroy(scene);
}

static void lattices_move_by_whole_cells(void** state) {
    ty_scene* scene = make_room(*state);
    const ty_lpv_def def = {.place = TY_LPV_PLACE_CAMERA, .resolution = 16, .cascades = 2, .extent = 4};
    ty_grid_box boxes[3][TY_LPV_CASCADES_MAX];
    int32_t count = 0;
    for (int i = 0; i < 3; ++i) {
        look_from(scene, 0.55 + (i == 1 ? 0.19 : i == 2 ? 0.25 : 0), 1.1, -0.3);
        assert_int_equal(ty_lattice_place(scene, &def, boxes[i], &count), TY_OK);
    }
    for (int32_t i = 0; i < 2; ++i) {
        assert_memory_equal(boxes[0][i].lower, boxes[1][i].lower, sizeof boxes[0][i].lower);
        assert_memory_equal(boxes[0][i].upper, boxes[1][i].upper, sizeof boxes[0][i].upper);
    }
    assert_close(boxes[2][0].lower[0], boxes[0][0].lower[0] + 0.25, 1e-12);
    assert_close(boxes[2][0].lower[1], boxes[0][0].lower[1], 1e-12);
    ty_scene_destroy(scene);
}

static void empty_scenes_have_no_lattice(void** state) {
    ty_scene* scene = make_scene(*state);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    const ty_lpv_def def = {.resolution = 16, .cascades = 1};
    ty_grid_box boxes[TY_LPV_CASCADES_MAX];
    int32_t count = 0;
    assert_int_equal(ty_lattice_place(scene, &def, boxes, &count), TY_ERROR_ARGUMENT);
    assert_error(*state, "neither media nor surfaces");
    ty_scene_destroy(scene);
}

/* ---- lookups ---- */

static void lookups_are_linear(void** state) {
    ty_lattice* lattice = make_lattice(*state, 6, 5, 4, 2);
    for (int32_t z = 0; z < 4; ++z)
        for (int32_t y = 0; y < 5; ++y)
            for (int32_t x = 0; x < 6; ++x)
                lattice->light[2][3][cell_at(lattice, x, y, z)] = 1 + 0.5f * (float)x - 0.25f * (float)y + (float)z;
    uint64_t seed = 8;
    for (int i = 0; i < 1000; ++i) {
        const double x = uniform_in(&seed, 0.5, 5.5), y = uniform_in(&seed, 0.5, 4.5), z = uniform_in(&seed, 0.5, 3.5);
        ty_lattice_cells cells;
        assert_true(ty_lattice_find(lattice, ty_vec_make((float)x / 2, (float)y / 2, (float)z / 2), &cells));
        float values[TY_SH_TERMS];
        ty_lattice_values(lattice, &cells, 2, 4, values);
        assert_close(values[3], 1 + 0.5 * (x - 0.5) - 0.25 * (y - 0.5) + z - 0.5, 1e-5);
    }
    ty_lattice_cells cells;
    assert_true(ty_lattice_find(lattice, ty_vec_make(-0.2f, 0.3f, 0.3f), &cells));
    assert_false(ty_lattice_find(lattice, ty_vec_make(-0.3f, 0.3f, 0.3f), &cells));
    assert_false(ty_lattice_find(lattice, ty_vec_make(1, 1, NAN), &cells));
    assert_true(ty_lattice_find(lattice, ty_vec_make(3, 2.5f, 2), &cells));
    assert_close(ty_lattice_mean(&cells, lattice->light[2][3]), 1 + 2.5 - 1 + 3, 1e-5);
    ty_lattice_destroy(lattice);
}

/* A wall between x = 2 and 3: each side sees its own cells alone. */
static void lookups_stay_on_their_side(void** state) {
    ty_lattice* lattice = make_lattice(*state, 6, 5, 4, 2);
    for (size_t i = 0; i < lattice->cells; ++i) lattice->light[0][0][i] = i % 6 < 3 ? 1.0f : 100.0f;
    for (int32_t dy = -1; dy <= 1; ++dy)
        for (int32_t dz = -1; dz <= 1; ++dz)
            for (size_t i = 0; i < lattice->cells; ++i) {
                if (i % 6 == 3) lattice->transmission[ty_lpv_link(1, dy, dz)][i] = 0;
                if (i % 6 == 2) lattice->transmission[ty_lpv_link(-1, dy, dz)][i] = 0;
            }
    lattice->blocked = true;
    ty_lattice_cells cells;
    for (float x = 0.05f; x < 3; x += 0.1f) {
        assert_true(ty_lattice_find(lattice, ty_vec_make(x, 1.21f, 0.83f), &cells));
        assert_close(ty_lattice_mean(&cells, lattice->light[0][0]), x < 1.5f ? 1 : 100, 1e-4);
    }
    memset(lattice->transmission[0], 0, lattice->cells);
    for (int32_t k = 0; k < TY_LPV_LINKS; ++k) memset(lattice->transmission[k], 0, lattice->cells);
    assert_true(ty_lattice_find(lattice, ty_vec_make(1.49f, 1.21f, 0.83f), &cells));
    assert_close(ty_lattice_mean(&cells, lattice->light[0][0]), 1, 1e-5);
    ty_lattice_destroy(lattice);
}

static void nested_lattices_blend(void** state) {
    ty_lattice* lattices[2] = {make_lattice(*state, 8, 8, 8, 2), make_lattice(*state, 16, 16, 16, 2)};
    for (float x = 0.01f; x < 8.2f; x += 0.05f) {
        const ty_lattice_cascade_weights mix = ty_lattice_choose_cascades(lattices, 2, ty_vec_make(x, 1.9f, 1.9f));
        if (x < 2.99f && x > 1.01f) assert_true(mix.lattice[0] == 0 && mix.weight[0] == 1 && mix.lattice[1] == -1);
        if (x > 3.02f && x < 3.98f) {
            assert_true(mix.lattice[0] == 0 && mix.lattice[1] == 1);
            assert_close(mix.weight[0], (4 - (double)x) / 1.0, 1e-4);
            assert_close(mix.weight[0] + mix.weight[1], 1, 1e-6);
        }
        if (x > 4) assert_true(mix.lattice[0] == 1 && mix.weight[0] == 1 && mix.lattice[1] == -1);
    }
    assert_int_equal(ty_lattice_choose_cascades(lattices, 2, ty_vec_make(9, 1, 1)).lattice[0], -1);
    ty_lattice_destroy(lattices[0]);
    ty_lattice_destroy(lattices[1]);
}

/* ---- media that the lattice cannot hold ---- */

/* Delta scaling keeps sigma_t - g sigma_s and absorption; phase functions up to g = 1/2 are kept. */
static void forward_peaks_are_unscattered_light(void** state) {
    static const double cosines[3] = {-0.3, 0.5, 0.9};
    for (int i = 0; i < 3; ++i) {
        ty_lattice* lattice = make_lattice(*state, 4, 4, 4, 2);
        set_medium(lattice, 2, 0.5, cosines[i], false);
        lattice->reduces = true;
        const ty_lpv_cell_medium medium = ty_lattice_medium_in(lattice, 0, 5);
        const double g = (double)medium.g, scattering = (double)medium.scattering;
        assert_close((double)medium.extinction - g * scattering, 2.5 - 2 * cosines[i], 1e-5);
        assert_close((double)medium.extinction - scattering, 0.5, 1e-5);
        assert_close(g, fmin(cosines[i], 0.5), 1e-6);
        ty_lattice_destroy(lattice);
    }
}

/* Reduced depths of 20 a cell: cells at the border have 2 * 0.71 if nothing absorbs, those inside are as they are. */
static void dense_cells_at_borders_are_as_deep_as_a_step(void** state) {
    ty_lattice* lattice = make_lattice(*state, 5, 5, 5, 2);
    set_medium(lattice, 40, 0, 0, false);
    assert_int_equal(ty_lattice_find_border_scale(lattice), TY_OK);
    const double depth = 40 * (double)lattice->cell;
    assert_close((double)lattice->border_scale[0][cell_at(lattice, 0, 2, 2)] * depth, 2 * 0.7104, 1e-4);
    assert_close((double)lattice->border_scale[0][cell_at(lattice, 2, 2, 2)], 1, 1e-6);
    assert_close((double)ty_lattice_medium_in(lattice, 0, cell_at(lattice, 0, 2, 2)).extinction,
                 2 * 0.7104 / (double)lattice->cell, 1e-3);
    ty_lattice_destroy(lattice);
}

/* A landscape of 40 m with a cloud of 8 m: cells as small as the cloud needs, as far as a cube of them suffices. */
static void landscapes_have_finer_cells(void** state) {
    static const float cloud_side[2] = {8, 40};
    static const int32_t along[2] = {40, 16};
    for (int i = 0; i < 2; ++i) {
        const double half = 0.5 * (double)cloud_side[i], lower[3] = {-half, 0, -half}, upper[3] = {half, 1, half};
        ty_scene* scene = make_scene(*state);
        const ty_medium_def cloud = box_medium(lower, upper, 1, 0);
        ty_shape_def floor = ty_default_shape_def();
        ty_grid_box boxes[TY_LPV_CASCADES_MAX];
        ty_lpv_def def = ty_default_lpv_def();
        int32_t count;
        floor.kind = TY_SHAPE_QUAD;
        set3(floor.origin, -20, 0, 20);
        set3(floor.u, 40, 0, 0);
        set3(floor.v, 0, 0, -40);
        def.resolution = 16;
        assert_int_equal(ty_scene_add_medium(scene, &cloud), TY_OK);
        assert_int_equal(ty_scene_add_shape(scene, &floor), TY_OK);
        assert_int_equal(ty_scene_commit(scene), TY_OK);
        assert_int_equal(ty_lattice_place(scene, &def, boxes, &count), TY_OK);
        assert_int_equal(boxes[0].size[0], along[i]);
        ty_scene_destroy(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(links_share_all_light),
        cmocka_unit_test(shapes_point_along_links),
        cmocka_unit_test(waves_do_not_grow),
        cmocka_unit_test(steps_keep_what_is_not_absorbed),
        cmocka_unit_test_setup_teardown(energy_is_kept, start_context, stop_context),
        cmocka_unit_test_setup_teardown(scattering_brings_what_extinction_takes, start_context, stop_context),
        cmocka_unit_test_setup_teardown(books_balance_among_surfaces, start_context, stop_context),
        cmocka_unit_test_setup_teardown(closed_rooms_keep_light, start_context, stop_context),
        cmocka_unit_test_setup_teardown(lattices_diffuse_as_media_do, start_context, stop_context),
        cmocka_unit_test_setup_teardown(lamps_light_thins_out, start_context, stop_context),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test_setup_teardown(propagation_can_be_cancelled, start_context, stop_context),
        cmocka_unit_test(memory_is_given_back),
        cmocka_unit_test_setup_teardown(seen_light_counts_where_it_is, start_context, stop_context),
        cmocka_unit_test_setup_teardown(light_comes_in_through_faces, start_context, stop_context),
        cmocka_unit_test_setup_teardown(finer_lattices_see_what_is_around, start_context, stop_context),
        cmocka_unit_test_setup_teardown(lattices_are_nested, start_context, stop_context),
        cmocka_unit_test_setup_teardown(lattices_move_by_whole_cells, start_context, stop_context),
        cmocka_unit_test_setup_teardown(empty_scenes_have_no_lattice, start_context, stop_context),
        cmocka_unit_test_setup_teardown(lookups_are_linear, start_context, stop_context),
        cmocka_unit_test_setup_teardown(lookups_stay_on_their_side, start_context, stop_context),
        cmocka_unit_test_setup_teardown(nested_lattices_blend, start_context, stop_context),
        cmocka_unit_test_setup_teardown(forward_peaks_are_unscattered_light, start_context, stop_context),
        cmocka_unit_test_setup_teardown(dense_cells_at_borders_are_as_deep_as_a_step, start_context, stop_context),
        cmocka_unit_test_setup_teardown(landscapes_have_finer_cells, start_context, stop_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
