/* tyndall info of media by name. */
#include "cli/info/info.h"
#include "cli/text/text.h"

/* The visibility for printing media that need one, m. */
#define SHOWN_VISIBILITY 1000.0

enum { NAME_WIDTH = 28 };

static const char* const numbers[] = {[TY_PRESET_MEASURED] = "may be diluted, :PARTS",
                                      [TY_PRESET_WATER] = "",
                                      [TY_PRESET_VISIBILITY] = "needs its visibility, :METRES; shown at 1000"};
static const char* const kinds[] = {
    [TY_PRESET_MEASURED] = "measured", [TY_PRESET_WATER] = "water", [TY_PRESET_VISIBILITY] = "visibility"};

static void print_rgb(const float rgb[3]) {
    printf("  %9.4g %9.4g %9.4g", (double)rgb[0], (double)rgb[1], (double)rgb[2]);
}

static void print_medium(const char* name, const ty_medium_def* medium, const char* note) {
    cli_print_text(stdout, name, NAME_WIDTH);
    print_rgb(medium->sigma_s);
    print_rgb(medium->sigma_a);
    printf("  %5.3g %5.3g %5.3g%s%s\n", (double)medium->g[0], (double)medium->g[1], (double)medium->g[2],
           note[0] != '\0' ? "  " : "", note);
}

static void json_rgb(json_writer* json, const char* name, const float rgb[3]) {
    json_numbers(json, name, (const double[]){(double)rgb[0], (double)rgb[1], (double)rgb[2]}, 3);
}

/* The object stays open. */
static void json_medium(json_writer* json, const char* name, const ty_medium_def* medium) {
    json_open_object(json, NULL);
    json_text(json, "name", name);
    json_rgb(json, "sigma_s", medium->sigma_s);
    json_rgb(json, "sigma_a", medium->sigma_a);
    json_rgb(json, "g", medium->g);
}

static void list_presets(ty_context* context, json_writer* json) {
    for (int32_t i = 0; i < ty_medium_preset_count(); ++i) {
        const char* name = ty_medium_preset_name(i);
        const ty_preset_kind kind = ty_medium_preset_kind(i);
        ty_medium_def medium = ty_default_medium_def();
        if (kind == TY_PRESET_VISIBILITY)
            ty_medium_preset_with(name, SHOWN_VISIBILITY, &medium);
        else
            ty_medium_preset(name, &medium);
        if (ty_medium_mean_cosine(context, &medium, medium.g) != TY_OK) return;
        if (json == NULL) {
            print_medium(name, &medium, numbers[kind]);
            continue;
        }
        json_medium(json, name, &medium);
        json_text(json, "kind", kinds[kind]);
        if (kind == TY_PRESET_VISIBILITY) json_number(json, "visibility", SHOWN_VISIBILITY);
        json_close_object(json);
    }
}

int cli_info_media(cli_session* session, const char* medium, bool json) {
    ty_medium_def def = ty_default_medium_def();
    ty_result result = medium != NULL ? ty_medium_parse(session->context, medium, &def) : TY_OK;
    if (result == TY_OK) result = ty_medium_mean_cosine(session->context, &def, def.g);
    if (result != TY_OK) return cli_fail_reading(session, result);
    json_writer writer;
    if (json) {
        writer = json_begin(stdout);
        json_open_object(&writer, NULL);
        json_text(&writer, "kind", "media");
        json_open_array(&writer, "media");
    } else {
        printf("%-*s  %-31s  %-31s  mean cosine g\n", NAME_WIDTH, "medium", "scattering, 1/m (r, g, b)",
               "absorption, 1/m (r, g, b)");
    }
    if (medium == NULL) {
        list_presets(session->context, json ? &writer : NULL);
    } else if (json) {
        json_medium(&writer, medium, &def);
        json_close_object(&writer);
    } else {
        print_medium(medium, &def, "");
    }
    if (json) {
        json_close_array(&writer);
        json_close_object(&writer);
    }
    return CLI_DONE;
}
