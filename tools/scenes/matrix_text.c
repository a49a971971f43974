/* The scene files of the matrix: camera, media, lights and surfaces of each kind of surroundings. */
#include "scenes/matrix.h"

/* A box from its lower to its upper corner, units. */
typedef struct box {
    double lower[3], upper[3];
} box;

/* A kind of surroundings. */
typedef struct place {
    double eye[3], target[3], fov_y;
    box thin;           /* what media fill up to a moderate thickness */
    box thick;          /* what dense and opaque media fill: the camera and the lights are outside */
    double length[2];   /* sides of the two along the view, which thicknesses refer to */
    double light[2][3]; /* position of lights with a place, in thin and beside thick media */
    const char* surfaces;
} place;

#define GRAY "\"material\": {\"albedo\": 0.6}}"
#define RED "\"material\": {\"albedo\": [0.6, 0.2, 0.15]}}"

/* Floor, ceiling, back, front and left wall; the right wall depends on the lights. */
#define ROOM                                                                                                           \
    "{\"quad\": {\"origin\": [-2, 0, -2], \"u\": [0, 0, 4], \"v\": [4, 0, 0]}, " GRAY ",\n"                            \
    "{\"quad\": {\"origin\": [-2, 2.6, -2], \"u\": [4, 0, 0], \"v\": [0, 0, 4]}, " GRAY ",\n"                          \
    "{\"quad\": {\"origin\": [-2, 0, -2], \"u\": [4, 0, 0], \"v\": [0, 2.6, 0]}, " GRAY ",\n"                          \
    "{\"quad\": {\"origin\": [-2, 0, 2], \"u\": [0, 2.6, 0], \"v\": [4, 0, 0]}, " GRAY ",\n"                           \
    "{\"quad\": {\"origin\": [-2, 0, -2], \"u\": [0, 2.6, 0], \"v\": [0, 0, 4]}, " RED ",\n"                           \
    "{\"box\": [[-1.5, 0, -1.5], [-0.9, 1.2, -0.9]], " GRAY                                                            \
    ",\n{\"sphere\": {\"center\": [1.2, 0.4, -1], \"radius\": 0.4}, " GRAY

static const char closed_wall[] = "{\"quad\": {\"origin\": [2, 0, -2], \"u\": [0, 0, 4], \"v\": [0, 2.6, 0]}, " GRAY;
/* With a window of 2 m by 1.4 m. */
static const char open_wall[] =
    "{\"quad\": {\"origin\": [2, 0, -2], \"u\": [0, 0, 4], \"v\": [0, 0.8, 0]}, " GRAY ",\n"
    "{\"quad\": {\"origin\": [2, 2.2, -2], \"u\": [0, 0, 4], \"v\": [0, 0.4, 0]}, " GRAY ",\n"
    "{\"quad\": {\"origin\": [2, 0.8, -2], \"u\": [0, 0, 0.8], \"v\": [0, 1.4, 0]}, " GRAY ",\n"
    "{\"quad\": {\"origin\": [2, 0.8, 0.8], \"u\": [0, 0, 1.2], \"v\": [0, 1.4, 0]}, " GRAY;

#define TERRAIN                                                                                                        \
    "{\"quad\": {\"origin\": [-20, 0, 20], \"u\": [40, 0, 0], \"v\": [0, 0, -40]}, "                                   \
    "\"material\": {\"albedo\": [0.3, 0.35, 0.2]}},\n"                                                                 \
    "{\"sphere\": {\"center\": [-3, -2, -4], \"radius\": 4}, " GRAY                                                    \
    ",\n{\"sphere\": {\"center\": [3.5, -1.5, -2], \"radius\": 2.8}, " RED                                             \
    ",\n{\"sphere\": {\"center\": [0, -1.6, 2.5], \"radius\": 2}, " GRAY                                               \
    ",\n{\"box\": [[-2.2, 0, 0.6], [-1.7, 1.4, 1.1]], " GRAY

#define LEVEL                                                                                                          \
    "{\"quad\": {\"origin\": [-5, 0, 4], \"u\": [10, 0, 0], \"v\": [0, 0, -8]}, " GRAY ",\n"                           \
    "{\"box\": [[-5.2, 0, -4.2], [5, 3.2, -4]], " RED ",\n{\"box\": [[-5.2, 0, -4], [-5, 3.2, 4]], " GRAY              \
    ",\n{\"box\": [[1, 2.7, -4], [5, 2.9, 4]], " GRAY ",\n{\"box\": [[0.8, 0, -3], [1.1, 2.7, -2.7]], " GRAY           \
    ",\n{\"box\": [[0.8, 0, 2], [1.1, 2.7, 2.3]], " GRAY ",\n{\"box\": [[-2.6, 0, -2.5], [-2.2, 3, -2.1]], " GRAY      \
    ",\n{\"box\": [[-1.6, 0, 1], [0.4, 0.9, 1.6]], " RED ",\n{\"box\": [[4.8, 0, -4], [5, 3.2, 1]], " GRAY

static const place places[] = {
    [MATRIX_OPEN] = {{0, 0.5, 4.2},
                     {0, 0, 0},
                     36,
                     {{-1, -1, -1}, {1, 1, 1}},
                     {{-1, -1, -1}, {1, 1, 1}},
                     {2, 2},
                     {{0.3, 0.4, 0.2}, {1.4, 1.3, 0.8}},
                     ""},
    [MATRIX_ROOM] = {{-0.3, 1.4, 1.9},
                     {0.1, 1.1, -1},
                     66,
                     {{-2, 0, -2}, {2, 2.6, 2}},
                     {{-0.8, 0.3, -0.8}, {0.8, 1.7, 0.4}},
                     {4, 1.2},
                     {{0.6, 2.1, -0.3}, {0.6, 2.2, -0.3}},
                     ROOM},
    [MATRIX_TERRAIN] = {{0, 2.4, 8},
                        {0, 0.7, 0},
                        38,
                        {{-4, 0, -4}, {4, 1.6, 4}},
                        {{-4, 0, -4}, {4, 1.6, 4}},
                        {4, 4},
                        {{0.6, 1.2, 1}, {0.8, 2.6, 1.2}},
                        TERRAIN},
    [MATRIX_LEVEL] = {{-4.4, 1.8, 3.6},
                      {0.6, 1.1, -1},
                      62,
                      {{-5, 0, -4}, {5, 3, 4}},
                      {{-1.4, 0.1, -2.2}, {0.6, 1.6, -0.4}},
                      {6, 2},
                      {{-0.4, 2.3, -0.4}, {-0.4, 2.4, -0.4}},
                      LEVEL},
};

static const double thicknesses[] = {0, 0.3, 3, 30, 300};
static const double cosines[] = {0, 0.5, 0.9, 0.96};
static const double albedos[][3] = {{0.55, 0.5, 0.45}, {0.92, 0.9, 0.87}, {1, 1, 1}};

static void print_vector(FILE* file, const double v[3]) {
    fprintf(file, "[%.5g, %.5g, %.5g]", v[0], v[1], v[2]);
}

static void print_box(FILE* file, const box* bounds) {
    fputs("[", file);
    print_vector(file, bounds->lower);
    fputs(", ", file);
    print_vector(file, bounds->upper);
    fputs("]", file);
}

static bool is_thick(const matrix_scene* scene) {
    return scene->values[MATRIX_THICKNESS] >= MATRIX_DENSE;
}

/* ---- media ---- */

static void print_coefficients(FILE* file, const matrix_scene* scene, double sigma_t, double g) {
    fprintf(file, "\"sigma_t\": %.5g, \"g\": %.5g, \"albedo\": ", sigma_t, g);
    print_vector(file, albedos[scene->values[MATRIX_ALBEDO]]);
}

/* A ball of another g in the middle of the first medium. */
static void print_ball(FILE* file, const matrix_scene* scene, const box* bounds, double sigma_t, double g) {
    double center[3], smallest = 1e30;
    for (int a = 0; a < 3; ++a) {
        const double side = bounds->upper[a] - bounds->lower[a];
        center[a] = 0.5 * (bounds->lower[a] + bounds->upper[a]);
        if (side < smallest) smallest = side;
    }
    fputs(",\n    {\"bounds\": {\"sphere\": {\"center\": ", file);
    print_vector(file, center);
    fprintf(file, ", \"radius\": %.5g}}, ", 0.4 * smallest);
    print_coefficients(file, scene, sigma_t, g);
    fputs("}", file);
}

static void print_media(FILE* file, const matrix_scene* scene) {
    const place* at = &places[scene->values[MATRIX_SURROUNDINGS]];
    const bool thick = is_thick(scene);
    const box* bounds = thick ? &at->thick : &at->thin;
    const double sigma_t = thicknesses[scene->values[MATRIX_THICKNESS]] / at->length[thick];
    const double g = cosines[scene->values[MATRIX_G]];
    fputs("  \"media\": [\n    {\"bounds\": ", file);
    print_box(file, bounds);
    fputs(", ", file);
    if (scene->values[MATRIX_MEDIUM] == MATRIX_GRID)
        fputs("\"density\": {\"noise\": {\"kind\": \"fbm\", \"resolution\": 32, \"frequency\": 3, \"octaves\": 3}}, ",
              file);
    if (scene->values[MATRIX_MEDIUM] == MATRIX_EMISSIVE) fputs("\"emission\": {\"radiance\": [1, 0.6, 0.3]}, ", file);
    print_coefficients(file, scene, sigma_t, g);
    fputs("}", file);
    if (scene->values[MATRIX_MEDIUM] == MATRIX_SEVERAL) print_ball(file, scene, bounds, 2 * sigma_t, 0.5 * g);
    fputs("\n  ],\n", file);
}

/* ---- lights and surfaces ---- */

/* Lights with a place shine at the middle of the media from above. */
static void print_placed_light(FILE* file, const matrix_scene* scene, const double light[3]) {
    const int32_t kind = scene->values[MATRIX_LIGHT];
    fprintf(file, "{\"type\": \"%s\", \"%s\": ", matrix_factors[MATRIX_LIGHT].values[kind],
            kind == MATRIX_AREA ? "origin" : "position");
    print_vector(file, light);
    if (kind == MATRIX_POINT) fputs(", \"intensity\": [10, 9, 8]}", file);
    if (kind == MATRIX_SPOT)
        fputs(", \"direction\": [-0.3, -1, -0.25], \"cone\": 70, \"intensity\": [30, 27, 24]}", file);
    if (kind == MATRIX_AREA) fputs(", \"u\": [0.6, 0, 0], \"v\": [0, 0, 0.4], \"radiance\": [60, 54, 48]}", file);
}

static void print_lights(FILE* file, const matrix_scene* scene, const double light[3]) {
    fputs("  \"lights\": [", file);
    switch (scene->values[MATRIX_LIGHT]) {
    case MATRIX_DIRECTIONAL:
        fputs("{\"type\": \"directional\", \"direction\": [-1, -0.75, -0.3], \"irradiance\": [6, 5.5, 5]}", file);
        break;
    case MATRIX_CONSTANT: fputs("{\"type\": \"environment\", \"radiance\": [0.8, 0.9, 1]}", file); break;
    case MATRIX_MAP: fputs("{\"type\": \"environment\", \"file\": \"map.exr\"}", file); break;
    case MATRIX_SKY:
        fputs("{\"type\": \"environment\", \"scale\": 4, \"sky\": {\"sun_direction\": [-1, -0.75, -0.3], "
              "\"resolution\": 64}}",
              file);
        break;
    case MATRIX_MESH: break;
    default: print_placed_light(file, scene, light);
    }
    fputs("],\n", file);
}

static bool has_window(const matrix_scene* scene) {
    const int32_t light = scene->values[MATRIX_LIGHT];
    return light == MATRIX_DIRECTIONAL || light >= MATRIX_CONSTANT;
}

static void print_surfaces(FILE* file, const matrix_scene* scene, const double light[3]) {
    const int32_t surroundings = scene->values[MATRIX_SURROUNDINGS];
    const bool mesh = scene->values[MATRIX_LIGHT] == MATRIX_MESH;
    fprintf(file, "  \"geometry\": [%s", places[surroundings].surfaces);
    if (surroundings == MATRIX_ROOM) fprintf(file, ",\n%s", has_window(scene) ? open_wall : closed_wall);
    if (mesh && surroundings != MATRIX_OPEN) fputs(",\n", file);
    if (mesh) {
        fputs("{\"sphere\": {\"center\": ", file);
        print_vector(file, light);
        fputs(", \"radius\": 0.15}, \"material\": {\"albedo\": 0.2, \"emission\": [120, 108, 96]}}", file);
    }
    fputs("],\n", file);
}

void matrix_print_scene(const matrix_scene* scene, FILE* file) {
    const place* at = &places[scene->values[MATRIX_SURROUNDINGS]];
    const double* light = at->light[is_thick(scene)];
    fputs("{\n  \"tyndall\": 1,\n  \"camera\": {\"position\": ", file);
    print_vector(file, at->eye);
    fputs(", \"target\": ", file);
    print_vector(file, at->target);
    fprintf(file, ", \"fov_y\": %g, \"resolution\": [%d, %d]},\n", at->fov_y, MATRIX_WIDTH, MATRIX_HEIGHT);
    print_media(file, scene);
    print_lights(file, scene, light);
    print_surfaces(file, scene, light);
    fprintf(file, "  \"render\": {\"method\": \"path\", \"spp\": %d}\n}\n", MATRIX_SAMPLES);
}
