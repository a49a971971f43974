/* Texture coordinates for lightmaps: stretch, overlaps, padding, fill; and the copy of a glTF file that has them. */
#include "strict_fixture.h"

#include "bake/unwrap/conformal.h"

#include <math.h>

enum { RINGS = 24, TURNS = 3, STEPS = 32, VERTICES_MAX = 4096, TRIANGLES_MAX = 8192 };

static float positions[3 * VERTICES_MAX];
static uint32_t indices[3 * TRIANGLES_MAX];
static ty_unwrap_mesh mesh;

static uint32_t add_vertex(float x, float y, float z) {
    float* p = positions + 3 * mesh.vertex_count;
    p[0] = x;
    p[1] = y;
    p[2] = z;
    return (uint32_t)mesh.vertex_count++;
}

static void add_triangle(uint32_t a, uint32_t b, uint32_t c) {
    uint32_t* t = indices + 3 * mesh.triangle_count++;
    t[0] = a;
    t[1] = b;
    t[2] = c;
}

static void begin_mesh(void) {
    mesh = (ty_unwrap_mesh){.positions = positions, .indices = indices};
}

static void make_ball(void) {
    begin_mesh();
    for (int i = 0; i <= RINGS; ++i)
        for (int k = 0; k < 2 * RINGS; ++k) {
            const float theta = 3.14159265f * (float)i / RINGS, phi = 3.14159265f * (float)k / RINGS;
            add_vertex(sinf(theta) * cosf(phi), sinf(theta) * sinf(phi), cosf(theta));
        }
    for (uint32_t i = 0; i < RINGS; ++i)
        for (uint32_t k = 0; k < 2 * RINGS; ++k) {
            const uint32_t next = (k + 1) % (2 * RINGS), row = 2 * RINGS * i, below = row + 2 * RINGS;
            if (i < RINGS - 1) add_triangle(row + k, below + k, below + next);
            if (i > 0) add_triangle(row + k, below + next, row + next);
        }
}

/* A ramp around an axis: faces all alike, and its turns lie over one another. */
static void make_ramp(void) {
    begin_mesh();
    for (int i = 0; i <= TURNS * STEPS; ++i) {
        const float angle = 6.2831853f * (float)i / STEPS, z = 0.02f * (float)i;
        add_vertex(cosf(angle), sinf(angle), z);
        add_vertex(2 * cosf(angle), 2 * sinf(angle), z);
    }
    for (uint32_t i = 0; i < TURNS * STEPS; ++i) {
        add_triangle(2 * i, 2 * i + 1, 2 * i + 3);
        add_triangle(2 * i, 2 * i + 3, 2 * i + 2);
    }
}

/* A box whose faces have vertices of their own. */
static void make_box(float x, float y, float z) {
    static const int faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    begin_mesh();
    for (int f = 0; f < 6; ++f) {
        uint32_t v[4];
        for (int k = 0; k < 4; ++k) {
            const int corner = faces[f][k];
            v[k] = add_vertex(corner & 1 ? x : 0, corner & 2 ? y : 0, corner & 4 ? z : 0);
        }
        add_triangle(v[0], v[1], v[2]);
        add_triangle(v[0], v[2], v[3]);
    }
}

static ty_unwrap unwrap_at(double density, double stretch) {
    const ty_unwrap_def def = {.density = density, .stretch = stretch, .padding = 4};
    ty_unwrap out;
    assert_int_equal(ty_unwrap_mesh_create(context, &mesh, &def, &out), TY_OK);
    return out;
}

/* True for points within a triangle of the map, not on its edges. */
static bool within(const float* uv, float x, float y) {
    const float area = (uv[2] - uv[0]) * (uv[5] - uv[1]) - (uv[3] - uv[1]) * (uv[4] - uv[0]);
    for (int k = 0; k < 3; ++k) {
        const float *a = uv + 2 * k, *b = uv + 2 * ((k + 1) % 3);
        if (((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area < 1e-3f) return false;
    }
    return true;
}

/* The points of a raster with `scale` points a texel belong to at most one triangle, and points of different charts are
 * apart by the padding. */
static void check_map(const ty_unwrap* u, int scale) {
    const int width = u->width * scale, height = u->height * scale;
    int32_t* owner = calloc((size_t)width * (size_t)height, sizeof *owner);
    assert_non_null(owner);
    for (int64_t t = 0; t < u->triangle_count; ++t) {
        const float* uv = u->uv + 6 * t;
        float low[2] = {1, 1}, high[2] = {0, 0};
        for (int k = 0; k < 6; ++k) {
            assert_true(uv[k] > 0 && uv[k] < 1);
            low[k % 2] = fminf(low[k % 2], uv[k]);
            high[k % 2] = fmaxf(high[k % 2], uv[k]);
        }
        for (int y = (int)(low[1] * (float)height); y <= (int)(high[1] * (float)height) && y < height; ++y)
            for (int x = (int)(low[0] * (float)width); x <= (int)(high[0] * (float)width) && x < width; ++x) {
                if (!within(uv, ((float)x + 0.5f) / (float)width, ((float)y + 0.5f) / (float)height)) continue;
                assert_int_equal(owner[y * width + x], 0);
                owner[y * width + x] = u->chart[t] + 1;
            }
    }
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int step = 1; step < 4 * scale; ++step) {
                const int32_t here = owner[y * width + x];
                if (here == 0) break;
                if (x + step < width)
                    assert_true(owner[y * width + x + step] == 0 || owner[y * width + x + step] == here);
                if (y + step < height)
                    assert_true(owner[(y + step) * width + x] == 0 || owner[(y + step) * width + x] == here);
            }
    free(owner);
}

static void check_unwrap(const char* name, double density, double stretch, int32_t charts_max, double fill_min) {
    ty_unwrap u = unwrap_at(density, stretch);
    print_message("%s: %d charts, %d x %d, filled %.3f, stretch %.3f, mean %.3f\n", name, (int)u.charts, (int)u.width,
                  (int)u.height, u.fill, u.stretch, u.mean_stretch);
    assert_true(u.stretch <= stretch * 1.0001);
    assert_true(u.mean_stretch >= 0.9999 && u.mean_stretch <= u.stretch);
    assert_true(u.charts <= charts_max);
    assert_true(u.fill >= fill_min && u.fill <= 1);
    check_map(&u, 3);
    ty_unwrap_free(context, &u);
}

/* Measured: 2 charts, 0.59 of the map; 8 charts, 0.47. By planes alone: 10 and 46 charts. */
static void a_ball_has_few_charts(void** state) {
    (void)state;
    make_ball();
    check_unwrap("ball", 32, 1.5, 3, 0.54);
    check_unwrap("ball, less stretch", 32, 1.1, 12, 0.42);
}

/* A wall of 300 degrees, of quads that are cut alike. */
static void make_tube(void) {
    begin_mesh();
    for (int i = 0; i <= STEPS; ++i) {
        const float angle = 5.2359878f * (float)i / STEPS;
        add_vertex(cosf(angle), sinf(angle), 0);
        add_vertex(cosf(angle), sinf(angle), 2);
    }
    for (uint32_t i = 0; i < STEPS; ++i) {
        add_triangle(2 * i, 2 * i + 2, 2 * i + 3);
        add_triangle(2 * i, 2 * i + 3, 2 * i + 1);
    }
}

/* A developable surface is one chart without stretch; measured: 1 + 1e-5. */
static void a_tube_is_unrolled(void** state) {
    (void)state;
    make_tube();
    ty_unwrap u = unwrap_at(16, 1.5);
    print_message("tube: %d charts, stretch %.6f\n", (int)u.charts, u.stretch);
    assert_int_equal(u.charts, 1);
    assert_true(u.stretch < 1.001);
    check_map(&u, 3);
    ty_unwrap_free(context, &u);
}

/* A map that halves lengths along u and doubles those along v; one that turns and shears, against the singular values
 * of its inverse; and one without area. */
static void stretch_is_that_of_the_singular_values(void** state) {
    (void)state;
    begin_mesh();
    add_triangle(add_vertex(0, 0, 0), add_vertex(2, 0, 0), add_vertex(0, 0, 1));
    double stretch[2];
    assert_true(ty_unwrap_stretch_of(&mesh, 0, (const float[]){1, 1, 2, 1, 1, 3}, stretch));
    assert_float_equal(stretch[0], 2, 1e-6);
    assert_float_equal(stretch[1], 0.5, 1e-6);
    /* (x, y) to (x + y, y): singular values (sqrt(5) + 1) / 2 and (sqrt(5) - 1) / 2, as of its inverse */
    assert_true(ty_unwrap_stretch_of(&mesh, 0, (const float[]){0, 0, 2, 0, 1, 1}, stretch));
    assert_float_equal(stretch[0], 1.6180340, 1e-6);
    assert_float_equal(stretch[1], 0.6180340, 1e-6);
    assert_false(ty_unwrap_stretch_of(&mesh, 0, (const float[]){0, 0, 1, 1, 2, 2}, stretch));
}

/* Right triangles of 16 x 12 texels; boxes with their padding have 0.269 at most. */
static void charts_lie_in_each_others_boxes(void** state) {
    (void)state;
    begin_mesh();
    for (int i = 0; i < 100; ++i) {
        const float x = 9 * (float)(i % 10), y = 7 * (float)(i / 10);
        add_triangle(add_vertex(x, y, 0), add_vertex(x + 8, y, 0), add_vertex(x, y + 6, 0));
    }
    const ty_unwrap_def def = {.density = 2, .stretch = 1.5, .padding = 4};
    ty_unwrap u;
    assert_int_equal(ty_unwrap_mesh_create(context, &mesh, &def, &u), TY_OK);
    print_message("triangles: %d x %d, filled %.4f\n", (int)u.width, (int)u.height, u.fill);
    assert_int_equal(u.charts, 100);
    assert_true(u.fill > 0.3);
    check_map(&u, 3);
    ty_unwrap_free(context, &u);
}

/* Two triangles of a face are one chart; measured: 0.66 of the map. */
static void a_box_has_six_charts(void** state) {
    (void)state;
    make_box(3, 2, 1);
    check_unwrap("box", 16, 1.5, 6, 0.6);
}

/* Each turn needs a chart of its own; measured: 3 charts, 0.38 of the map. */
static void turns_do_not_overlap(void** state) {
    (void)state;
    make_ramp();
    check_unwrap("ramp", 16, 1.5, 4, 0.34);
}

static void triangles_without_area_are_placed(void** state) {
    (void)state;
    begin_mesh();
    for (int i = 0; i < 3; ++i) add_vertex((float)i, 0, 0);
    add_triangle(0, 1, 2);
    add_triangle(1, 1, 1);
    ty_unwrap u = unwrap_at(8, 1.5);
    for (int k = 0; k < 12; ++k) assert_true(u.uv[k] > 0 && u.uv[k] < 1);
    assert_true(u.fill == 0);
    ty_unwrap_free(context, &u);
}

static void large_maps_are_coarser(void** state) {
    (void)state;
    make_box(3, 2, 1);
    ty_unwrap u = unwrap_at(1e5, 1.5);
    assert_true(u.width <= TY_UNWRAP_SIDE_MAX && u.height <= TY_UNWRAP_SIDE_MAX && u.density < 1e5);
    ty_unwrap_free(context, &u);
}

static ty_result unwrap_again(ty_context* own, void* user) {
    const ty_unwrap_def def = {.density = 8, .stretch = 1.5, .padding = 2};
    ty_unwrap out;
    const ty_result result = ty_unwrap_mesh_create(own, user, &def, &out);
    ty_unwrap_free(own, &out);
    return result;
}

static void short_memory_is_survived(void** state) {
    (void)state;
    make_box(1, 1, 1);
    assert_true(check_short_memory(context, &memory, unwrap_again, &mesh) > 5);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_ball_has_few_charts),
        cmocka_unit_test(a_box_has_six_charts),
        cmocka_unit_test(turns_do_not_overlap),
        cmocka_unit_test(triangles_without_area_are_placed),
        cmocka_unit_test(a_tube_is_unrolled),
        cmocka_unit_test(stretch_is_that_of_the_singular_values),
        cmocka_unit_test(charts_lie_in_each_others_boxes),
        cmocka_unit_test(large_maps_are_coarser),
        cmocka_unit_test(short_memory_is_survived),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
