/* The light on cells as a texture: what the cells of media scatter and emit, and their extinction. */
#include "cli/fluence/fog_texture.h"
#include "base/context.h"
#include "cli/session/session.h"
#include "cli/text/text_file.h"
#include "direct/media/grid_medium.h"

#include <math.h>
#include <string.h>

enum { PATH_SIZE = 4096 };

#define PER_4PI 0.07957747154594767

static ty_result fill(ty_context* context, const ty_grid_medium* medium, const cli_fog_texture* fog, ty_image** out) {
    static const char* const names[] = {"R", "G", "B", "A"};
    ty_result result = ty_image_create(context, fog->size[0], fog->size[1] * fog->size[2], 4, names, out);
    if (result != TY_OK) return result;
    for (size_t i = 0; i < medium->cells; ++i) {
        double alpha = 0;
        for (int c = 0; c < 3; ++c) {
            const double fluence = fog->fluence[3 * i + (size_t)c];
            const double emission = medium->emission[c] == NULL ? 0 : (double)medium->emission[c][i];
            const double scattered = (double)medium->scattering[c][i] * fluence;
            const double values[] = {(scattered + emission) * PER_4PI, fluence, scattered};
            ty_image_plane(*out, c)[i] = (float)values[fog->quantity];
            alpha += (double)(fog->quantity == CLI_FOG_UNCOLLIDED ? medium->g : medium->extinction)[c][i] / 3;
        }
        ty_image_plane(*out, 3)[i] = (float)alpha;
    }
    return TY_OK;
}

/* ---- The sidecar ---- */

typedef struct sidecar {
    const cli_fog_texture* fog;
    const char* texture;
    bool z_up;
} sidecar;

static ty_result print_sidecar(ty_context* context, FILE* file, const void* user) {
    (void)context;
    const sidecar* s = user;
    static const char* const names[] = {"scatter", "fluence", "uncollided"};
    static const char* const texts[] = {"radiance scattered and emitted per metre, W m^-3 sr^-1", "fluence, W m^-2",
                                        "scattering coefficient times uncollided fluence, W m^-3"};
    const cli_fog_quantity quantity = s->fog->quantity;
    json_writer json = json_begin(file);
    json_open_object(&json, NULL);
    json_int(&json, "tyndall_fog", 1);
    json_text(&json, "texture", s->texture);
    json_text(&json, "up", s->z_up ? "+z" : "+y");
    json_numbers(&json, "lower", s->fog->lower, 3);
    json_numbers(&json, "upper", s->fog->upper, 3);
    json_numbers(&json, "size", (const double[]){s->fog->size[0], s->fog->size[1], s->fog->size[2]}, 3);
    json_text(&json, "quantity", names[quantity]);
    json_text(&json, "rgb", texts[quantity]);
    json_text(&json, "light",
              quantity == CLI_FOG_UNCOLLIDED ? "uncollided"
              : s->fog->scattered            ? "all but uncollided"
                                             : "all");
    json_text(&json, "alpha", quantity == CLI_FOG_UNCOLLIDED ? "mean cosine of the phase function" : "extinction, 1/m");
    json_text(&json, "layout", "x along the width, y along the height, z along the depth; texels are means of cells");
    json_close_object(&json);
    return TY_OK;
}

static ty_result write_sidecar(ty_context* context, const ty_scene* scene, const cli_fog_texture* fog,
                               const char* path) {
    char name[PATH_SIZE];
    const char* slash = strrchr(path, '/');
    const sidecar s = {fog, slash == NULL ? path : slash + 1, ty_scene_up_axis(scene) == TY_AXIS_Z};
    const char* dot = strrchr(path, '.');
    if (snprintf(name, sizeof name, "%.*s.json", (int)(dot - path), path) >= (int)sizeof name)
        return ty_fail(context, TY_ERROR_ARGUMENT, "%s: the path is too long", path);
    return cli_write_text_file(context, name, print_sidecar, &s);
}

ty_result cli_write_fog_texture(ty_context* context, const ty_scene* scene, const cli_fog_texture* fog,
                                const char* path) {
    ty_grid_box box;
    ty_grid_medium* medium = NULL;
    ty_image* image = NULL;
    for (int a = 0; a < 3; ++a) {
        box.lower[a] = fog->lower[a];
        box.upper[a] = fog->upper[a];
        box.size[a] = fog->size[a];
    }
    ty_result result = ty_grid_medium_create(scene, &box, &medium);
    if (result == TY_OK) result = fill(context, medium, fog, &image);
    if (medium != NULL) ty_grid_medium_destroy(medium);
    if (result == TY_OK) {
        ty_texels_def def = ty_default_texels_def();
        def.format = TY_TEXELS_HALF;
        def.slices = fog->size[2];
        def.zstd = cli_has_extension(path, ".ktx2") ? fog->zstd : 0;
        result = ty_texels_write(context, image, &def, path);
    }
    ty_image_destroy(image);
    return result == TY_OK ? write_sidecar(context, scene, fog, path) : result;
}
