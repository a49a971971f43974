/* Texture coordinates for lightmaps: stretch, overlaps, padding, fill; and the copy of a glTF file that has them. */
#include "strict_fixture.h"

#include "bake/unwrap/unwrap.h"

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

/* Measured: 10 charts, 0.48 of the map; 46 charts, 0.35. */
static void a_ball_has_few_charts(void** state) {
    (void)state;
    make_ball();
    check_unwrap("ball", 32, 1.5, 15, 0.4);
    check_unwrap("ball, less stretch", 32, 1.1, 70, 0.3);
}

/* Two triangles of a face are one chart; measured: 0.65 of the map. */
static void a_box_has_six_charts(void** state) {
    (void)state;
    make_box(3, 2, 1);
    check_unwrap("box", 16, 1.5, 6, 0.55);
}

/* Each turn needs a chart of its own, at least. */
static void turns_do_not_overlap(void** state) {
    (void)state;
    make_ramp();
    check_unwrap("ramp", 16, 1.5, 40, 0.1);
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
        cmocka_unit_test(a_ball_has_few_charts),  cmocka_unit_test(a_box_has_six_charts),
        cmocka_unit_test(turns_do_not_overlap),   cmocka_unit_test(triangles_without_area_are_placed),
        cmocka_unit_test(large_maps_are_coarser), cmocka_unit_test(short_memory_is_survived),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
