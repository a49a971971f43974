/* The light on cells as textures: what the cells of media scatter and emit, and their extinction; or that parted by how
 * shaders scatter it. */
#include "cli/fluence/fog_texture.h"
#include "base/constants.h"
#include "base/context.h"
#include "base/luminance.k.h"
#include "cli/session/session.h"
#include "cli/text/text_file.h"
#include "direct/media/grid_medium.h"
#include "solve/angular/harmonics.h"

#include <math.h>
#include <string.h>

enum { PATH_SIZE = 4096 };

/* The textures of CLI_FOG_PHASE; others have the first alone. */
typedef enum fog_part { PART_LIGHT = 0, PART_UNCOLLIDED = 1, PART_DIRECTIONS = 2, PARTS = 3 } fog_part;
static const char* const suffixes[PARTS] = {"", "_uncollided", "_directions"};

#define PER_4PI 0.07957747154594767

/* ---- Texels ---- */

static double mean_of(float* const planes[3], size_t cell) {
    return ((double)planes[0][cell] + (double)planes[1][cell] + (double)planes[2][cell]) / 3;
}

static double emission_of(const ty_grid_medium* medium, int c, size_t cell) {
    return medium->emission[c] == NULL ? 0 : (double)medium->emission[c][cell];
}

static void find_light(const ty_grid_medium* medium, const cli_fog_texture* fog, size_t cell, double texel[4]) {
    const double* fluence = fog->quantity == CLI_FOG_PHASE ? fog->split.rest : fog->fluence;
    for (int c = 0; c < 3; ++c) {
        const double value = fluence[3 * cell + (size_t)c];
        texel[c] = fog->quantity == CLI_FOG_FLUENCE
                       ? value
                       : ((double)medium->scattering[c][cell] * value + emission_of(medium, c, cell)) * PER_4PI;
    }
    texel[3] = mean_of(medium->extinction, cell);
}

static void find_uncollided(const ty_grid_medium* medium, const cli_fog_texture* fog, size_t cell, double texel[4]) {
    for (int c = 0; c < 3; ++c)
        texel[c] = (double)medium->scattering[c][cell] * fog->split.unscattered[3 * cell + (size_t)c];
    texel[3] = mean_of(medium->g, cell);
}

/* Light that is scattered along a direction omega over its mean of all directions is
 *
 *     1 + w (4 pi p(a . omega, x) - 1) + sum_(t > 0) c_t Y_t(omega),
 *
 * p being Henyey and Greenstein's phase function. A lobe has the axis a, the mean cosine x and the part w of the light.
 * Light of the Legendre moments 1, m1 and m2 about its flux has b = m2 / m1 and w = m1 / b, and scattering makes x = g
 * b of b. The terms c_t are what the moments have besides; the lobe continues them in higher bands. All of
 * these are of luminance; a channel departs from 1 by as much more or less as its mean cosine is larger or smaller. */
typedef struct directions {
    double axis[3], part, cosine;
    double terms[TY_CELL_TERMS];
    double channels[3]; /* factors of all that departs from 1, of red, green and blue */
} directions;

static const double min_lobe_cosine = 0.05, max_channel = 4;

/* phi_lm over phi_00 of even light, 1 / sqrt(4 pi). */
static void relate_moments(const float* moments, double out[TY_CELL_TERMS]) {
    const double scale = 1 / (sqrt(4 * TY_PI_F64) * fmax((double)moments[0], 1e-30));
    for (int t = 0; t < TY_CELL_TERMS; ++t) out[t] = scale * (double)moments[t];
}

static directions find_directions(const ty_grid_medium* medium, const cli_fog_texture* fog, size_t cell) {
    const double g = mean_of(medium->g, cell);
    directions d = {.part = 0};
    double scattered[3], emitted[3], moments[TY_CELL_TERMS], y[TY_CELL_TERMS], second = 0;
    for (int c = 0; c < 3; ++c) {
        scattered[c] = (double)medium->scattering[c][cell] * fog->split.rest[3 * cell + (size_t)c];
        emitted[c] = emission_of(medium, c, cell);
    }
    const double luminance = ty_luminance_f64(scattered),
                 scattered_part = luminance / (luminance + ty_luminance_f64(emitted));
    relate_moments(fog->split.moments + TY_CELL_TERMS * cell, moments);
    const double flux[3] = {moments[3], moments[1], moments[2]};
    const double length = sqrt(flux[0] * flux[0] + flux[1] * flux[1] + flux[2] * flux[2]);
    if (!(luminance > 0) || !(length > 0)) return d;
    for (int a = 0; a < 3; ++a) d.axis[a] = flux[a] / length;
    ty_harmonics_at(d.axis, TY_CELL_BANDS, y);
    for (int t = 4; t < 9; ++t) second += 4 * TY_PI_F64 / 5 * moments[t] * y[t]; /* addition theorem */
    const double first = fmin(sqrt(4 * TY_PI_F64 / 3) * length, 1), b = fmin(fmax(second / first, min_lobe_cosine), 1);
    for (int c = 0; c < 3; ++c) {
        const double part_c = scattered[c] > 0 ? scattered[c] / (scattered[c] + emitted[c]) : 0;
        d.channels[c] = fmin(
            fmax(part_c * (double)fog->split.cosines[3 * cell + (size_t)c] / (scattered_part * first), 0), max_channel);
    }
    d.part = scattered_part * first / b;
    d.cosine = g * b;
    for (int l = 1, t = 1; l < TY_CELL_BANDS; ++l)
        for (; t < (l + 1) * (l + 1); ++t)
            d.terms[t] = 4 * TY_PI_F64 * (scattered_part * pow(g, l) * moments[t] - d.part * pow(d.cosine, l) * y[t]);
    return d;
}

/* Slices of the texture of directions: the axis times the part, and the mean cosine; then four terms each; then the
 * factors of the channels. */
enum { CHANNEL_BLOCK = 1 + (TY_CELL_TERMS - 1) / 4, DIRECTION_BLOCKS };

static void find_direction_block(const directions* d, int block, double texel[4]) {
    for (int k = 0; k < 4 && block == CHANNEL_BLOCK; ++k) texel[k] = k < 3 ? d->channels[k] : 0;
    for (int k = 0; k < 4 && block < CHANNEL_BLOCK; ++k)
        texel[k] = block > 0 ? d->terms[4 * (block - 1) + k + 1] : k < 3 ? d->part * d->axis[k] : d->cosine;
}

static int blocks_of(fog_part part) {
    return part == PART_DIRECTIONS ? DIRECTION_BLOCKS : 1;
}

static ty_result fill(ty_context* context, const ty_grid_medium* medium, const cli_fog_texture* fog, fog_part part,
                      ty_image** out) {
    static const char* const names[] = {"R", "G", "B", "A"};
    const int blocks = blocks_of(part);
    const ty_result result =
        ty_image_create(context, fog->size[0], fog->size[1] * fog->size[2] * blocks, 4, names, out);
    for (size_t i = 0; i < medium->cells && result == TY_OK; ++i) {
        directions d = {.part = 0};
        double texel[4];
        if (part == PART_DIRECTIONS) d = find_directions(medium, fog, i);
        for (int block = 0; block < blocks; ++block) {
            if (part == PART_LIGHT) find_light(medium, fog, i, texel);
            if (part == PART_UNCOLLIDED) find_uncollided(medium, fog, i, texel);
            if (part == PART_DIRECTIONS) find_direction_block(&d, block, texel);
            for (int c = 0; c < 4; ++c) ty_image_plane(*out, c)[i + (size_t)block * medium->cells] = (float)texel[c];
        }
    }
    return result;
}

/* ---- The sidecar ---- */

/* The path with a suffix before its extension, or with another extension. */
static ty_result name_file(ty_context* context, const char* path, const char* suffix, const char* extension,
                           char out[PATH_SIZE]) {
    const char* dot = strrchr(path, '.');
    if (snprintf(out, PATH_SIZE, "%.*s%s%s", (int)(dot - path), path, suffix, extension != NULL ? extension : dot) >=
        PATH_SIZE)
        return ty_fail(context, TY_ERROR_ARGUMENT, "%s: the path is too long", path);
    return TY_OK;
}

typedef struct sidecar {
    const cli_fog_texture* fog;
    char textures[PARTS][PATH_SIZE];
    bool z_up;
    bool colored;     /* the extinction of channels differs */
    bool anisotropic; /* some of the media do not scatter evenly */
} sidecar;

static void look_at_medium(const ty_grid_medium* medium, sidecar* s) {
    for (size_t i = 0; i < medium->cells; ++i)
        for (int c = 0; c < 3; ++c) {
            s->colored = s->colored || medium->extinction[c][i] != medium->extinction[0][i];
            s->anisotropic = s->anisotropic || medium->g[c][i] != 0;
        }
}

/* In the form of the notes of tyndall convert. */
static void print_notes(json_writer* json, const sidecar* s) {
    const cli_fog_quantity quantity = s->fog->quantity;
    json_open_array(json, "comment");
    if (s->anisotropic && quantity == CLI_FOG_SCATTER)
        json_text(json, NULL, "approximated: phase function: light is scattered evenly");
    if (quantity == CLI_FOG_PHASE) {
        json_text(json, NULL, "approximated: phase function: that of Henyey and Greenstein of the same mean cosine");
        json_text(json, NULL, "approximated: directions: those of luminance, with a factor for each channel");
    }
    if (s->colored) json_text(json, NULL, "approximated: extinction: the mean of its channels");
    json_close_array(json);
}

static void print_texture(json_writer* json, const sidecar* s, fog_part part, const char* rgb, const char* alpha) {
    const char* slash = strrchr(s->textures[part], '/');
    json_text(json, "texture", slash == NULL ? s->textures[part] : slash + 1);
    json_text(json, "rgb", rgb);
    json_text(json, "alpha", alpha);
}

static ty_result print_sidecar(ty_context* context, FILE* file, const void* user) {
    (void)context;
    const sidecar* s = user;
    static const char* const names[] = {"scatter", "fluence", "phase"};
    const cli_fog_quantity quantity = s->fog->quantity;
    json_writer json = json_begin(file);
    json_open_object(&json, NULL);
    json_int(&json, "tyndall_fog", 1);
    json_text(&json, "up", s->z_up ? "+z" : "+y");
    json_numbers(&json, "lower", s->fog->lower, 3);
    json_numbers(&json, "upper", s->fog->upper, 3);
    json_numbers(&json, "size", (const double[]){s->fog->size[0], s->fog->size[1], s->fog->size[2]}, 3);
    json_text(&json, "layout", "x along the width, y along the height, z along the depth; texels are means of cells");
    json_text(&json, "quantity", names[quantity]);
    json_text(&json, "light",
              quantity == CLI_FOG_PHASE ? "all but unscattered light of lamps"
              : s->fog->scattered       ? "all but uncollided"
                                        : "all");
    print_notes(&json, s);
    print_texture(&json, s, PART_LIGHT,
                  quantity == CLI_FOG_FLUENCE ? "fluence, W m^-2"
                                              : "radiance scattered and emitted per metre, W m^-3 sr^-1",
                  "extinction, 1/m");
    if (quantity == CLI_FOG_PHASE) {
        json_open_object(&json, "uncollided");
        print_texture(&json, s, PART_UNCOLLIDED,
                      "scattering coefficient times fluence of unscattered light of lamps, W m^-3",
                      "mean cosine of the phase function");
        json_close_object(&json);
        json_open_object(&json, "directions");
        json_int(&json, "blocks", DIRECTION_BLOCKS);
        print_texture(
            &json, s, PART_DIRECTIONS,
            "axis of the lobe, whose length is its part of the light; in the slices of further blocks terms of "
            "harmonics, and in those of the last one the factors of the channels",
            "mean cosine of the lobe; in blocks of terms the same as rgb");
        json_close_object(&json);
    }
    json_close_object(&json);
    return TY_OK;
}

/* ---- The files ---- */

static ty_result write_part(ty_context* context, const ty_grid_medium* medium, const cli_fog_texture* fog,
                            fog_part part, const char* path) {
    ty_image* image = NULL;
    ty_result result = fill(context, medium, fog, part, &image);
    if (result == TY_OK) {
        ty_texels_def def = ty_default_texels_def();
        def.format = TY_TEXELS_HALF;
        def.slices = fog->size[2] * blocks_of(part);
        def.zstd = cli_has_extension(path, ".ktx2") ? fog->zstd : 0;
        result = ty_texels_write(context, image, &def, path);
    }
    ty_image_destroy(image);
    return result;
}

ty_result cli_write_fog_texture(ty_context* context, const ty_scene* scene, const cli_fog_texture* fog,
                                const char* path) {
    const int parts = fog->quantity == CLI_FOG_PHASE ? PARTS : 1;
    sidecar s = {.fog = fog, .z_up = ty_scene_up_axis(scene) == TY_AXIS_Z};
    char name[PATH_SIZE];
    ty_grid_box box;
    ty_grid_medium* medium = NULL;
    for (int a = 0; a < 3; ++a) {
        box.lower[a] = fog->lower[a];
        box.upper[a] = fog->upper[a];
        box.size[a] = fog->size[a];
    }
    ty_result result = ty_grid_medium_create(scene, &box, &medium);
    for (int part = 0; part < parts && result == TY_OK; ++part) {
        result = name_file(context, path, suffixes[part], NULL, s.textures[part]);
        if (result == TY_OK) result = write_part(context, medium, fog, (fog_part)part, s.textures[part]);
    }
    if (result == TY_OK) look_at_medium(medium, &s);
    if (medium != NULL) ty_grid_medium_destroy(medium);
    if (result == TY_OK) result = name_file(context, path, "", ".json", name);
    return result == TY_OK ? cli_write_text_file(context, name, print_sidecar, &s) : result;
}
