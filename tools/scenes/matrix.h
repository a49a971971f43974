/* Scenes of the matrix of methods: a covering set of kinds of lights, surroundings, media, thicknesses, g and albedo.
 */
#ifndef TY_TOOLS_MATRIX_H
#define TY_TOOLS_MATRIX_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

enum {
    MATRIX_SCENES = 64,
    MATRIX_NAME_SIZE = 56,
    MATRIX_VALUES_MAX = 8,
    MATRIX_WIDTH = 48, /* pixels */
    MATRIX_HEIGHT = 36,
    MATRIX_SAMPLES = 32, /* per pixel, of the scenes */
    MATRIX_SAMPLES_QUICK = 2
};

/* Factors in which scenes differ. */
typedef enum matrix_factor {
    MATRIX_LIGHT,
    MATRIX_SURROUNDINGS,
    MATRIX_MEDIUM,
    MATRIX_THICKNESS,
    MATRIX_G,
    MATRIX_ALBEDO,
    MATRIX_FACTORS
} matrix_factor;

typedef enum matrix_light {
    MATRIX_DIRECTIONAL,
    MATRIX_POINT,
    MATRIX_SPOT,
    MATRIX_AREA,
    MATRIX_MESH, /* surfaces that emit */
    MATRIX_CONSTANT,
    MATRIX_MAP,
    MATRIX_SKY
} matrix_light;

typedef enum matrix_surroundings { MATRIX_OPEN, MATRIX_ROOM, MATRIX_TERRAIN, MATRIX_LEVEL } matrix_surroundings;
typedef enum matrix_medium { MATRIX_HOMOGENEOUS, MATRIX_GRID, MATRIX_SEVERAL, MATRIX_EMISSIVE } matrix_medium;
typedef enum matrix_thickness {
    MATRIX_CLEAR,
    MATRIX_THIN,
    MATRIX_MODERATE,
    MATRIX_DENSE,
    MATRIX_OPAQUE
} matrix_thickness;

typedef struct matrix_scene {
    int32_t values[MATRIX_FACTORS]; /* index of the value of each factor */
} matrix_scene;

/* A factor's name for readers, and the names of its values. */
typedef struct matrix_factor_words {
    const char* name;
    const char* values[MATRIX_VALUES_MAX]; /* ended by NULL where fewer */
    int32_t count;
} matrix_factor_words;

extern const matrix_factor_words matrix_factors[MATRIX_FACTORS];

/* Fills in the scenes: every possible pair of values is in one of them, and as many triples as a greedy choice finds.
 * The same on every machine. */
void matrix_cover(matrix_scene scenes[MATRIX_SCENES]);
/* True if no two values of the scene exclude one another, such as emission without absorption. */
bool matrix_is_possible(const matrix_scene* scene);
/* "area_room_grid_thin_g0.5_a0.9" */
void matrix_name(const matrix_scene* scene, char out[MATRIX_NAME_SIZE]);
/* Writes a scene file, whose map is map.exr beside it. */
void matrix_print_scene(const matrix_scene* scene, FILE* file);

#endif
