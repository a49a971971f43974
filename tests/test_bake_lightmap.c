/* Lightmaps: from made-up light to an image: channels, texels within walls, seams, padding. */
#include "atlas_maker.h"

#include "bake/atlas/atlas.h"

#include <stdio.h>

static const double all[2] = {0, 1};

/* Four rectangles of a map with room between them, at heights 0..3; the first is twice as large. */
static mapped_mesh four_charts(void) {
    static const double u[4][2] = {{0.1, 0.45}, {0.61, 0.93}, {0.08, 0.3}, {0.6, 0.92}};
    static const double v[4][2] = {{0.1, 0.45}, {0.12, 0.4}, {0.6, 0.93}, {0.57, 0.9}};
    mapped_mesh mesh = mapped_nothing();
    for (int i = 0; i < 4; ++i) mapped_quad(&mesh, all, all, i, u[i], v[i]);
    return mesh;
}

/* Light that is told apart by chart, and within it. */
static void by_chart(const ty_bake_receiver* receiver, int64_t index, ty_bake_light* out) {
    (void)index;
    for (int c = 0; c < 3; ++c)
        out->irradiance[c][c] =
            1 + receiver->position[2] + 0.1f * receiver->position[0] + 0.01f * receiver->position[1];
}

static void directed(const ty_bake_receiver* receiver, int64_t index, ty_bake_light* out) {
    for (int layer = 0; layer < TY_BAKE_LAYERS; ++layer)
        for (int c = 0; c < 3; ++c) {
            out->irradiance[layer][c] = (float)(layer + 1) * (1 + receiver->position[0]);
            out->vector_irradiance[layer][c][c] = (float)(layer + 1) * (c == 2 ? -1.0f : 1.0f);
        }
    out->fluence[0] = 20;
    out->fluence[1] = 5; /* noise: less than the vector */
    out->variance[1] = 0.5f;
    out->samples = (int32_t)index + 1;
}

static void images_have_all_channels(void** state) {
    mapped_mesh mesh = mapped_nothing();
    mapped_quad(&mesh, all, all, 0, all, all);
    ty_scene* scene = mapped_scene(*state, &mesh, false, true);
    const ty_atlas_def def = sized(16);
    ty_atlas* atlas = mapped_atlas(scene, &def);
    ty_image* image = image_of(atlas, directed);
    static const char* const layers[4] = {"direct", "indirect", "single", "multiple"};
    static const char* const channels[3] = {"R", "G", "B"};
    assert_int_equal(ty_image_channel_count(image), 29);
    for (int i = 0; i < 256; ++i) {
        for (int c = 0; c < 3; ++c) {
            float sum = 0;
            for (int layer = 0; layer < 4; ++layer) {
                char name[32];
                snprintf(name, sizeof name, "%s.%s", layers[layer], channels[c]);
                sum += plane_of(image, name)[i];
            }
            assert_true(plane_of(image, channels[c])[i] == sum);
        }
        assert_close((double)plane_of(image, "R")[i], 10 * (1 + (double)atlas->receivers[i].position[0]), 1e-4);
        assert_close((double)plane_of(image, "L1.RX")[i], 10.0 / 20, 1e-6);
        assert_close((double)plane_of(image, "L1.GY")[i], 1, 1e-6);
        assert_close((double)plane_of(image, "L1.BZ")[i], -1, 1e-6);
        assert_true(plane_of(image, "L1.RY")[i] == 0);
        assert_true(plane_of(image, "coverage.A")[i] == 1);
        assert_true(plane_of(image, "samples.N")[i] == (float)(i + 1));
        assert_true(plane_of(image, "variance.G")[i] == 0.5f);
    }
    ty_image_destroy(image);
    ty_atlas_destroy(atlas);
    ty_scene_destroy(scene);
    mapped_free(&mesh);
}

/* Every texel around charts has the light of the nearest that counts, as found by looking at all. */
static void padding_surrounds_charts(void** state) {
    static const int32_t paddings[] = {0, 1, 4, 64};
    mapped_mesh mesh = four_charts();
    ty_scene* scene = mapped_scene(*state, &mesh, false, true);
    for (size_t p = 0; p < sizeof paddings / sizeof *paddings; ++p) {
        enum { SIDE = 48 };
        ty_atlas_def def = sized(SIDE);
        def.padding = paddings[p];
        ty_atlas* atlas = mapped_atlas(scene, &def);
        ty_bake_light* lit = made_up(atlas, by_chart);
        ty_image* image = NULL;
        assert_int_equal(ty_atlas_create_image(atlas, lit, &image), TY_OK);
        const float* plane = plane_of(image, "R");
        for (int32_t y = 0; y < SIDE; ++y)
            for (int32_t x = 0; x < SIDE; ++x) {
                const int32_t here = y * SIDE + x;
                int32_t least = INT32_MAX;
                bool found = false;
                for (int32_t i = 0; i < SIDE * SIDE; ++i) {
                    const int32_t dx = i % SIDE - x, dy = i / SIDE - y;
                    if (atlas->receiver[i] < 0 || abs(dx) > def.padding || abs(dy) > def.padding) continue;
                    if (dx * dx + dy * dy < least) least = dx * dx + dy * dy;
                }
                if (least == INT32_MAX) {
                    assert_true(plane[here] == 0);
                    continue;
                }
                for (int32_t i = 0; i < SIDE * SIDE && !found; ++i) {
                    const int32_t dx = i % SIDE - x, dy = i / SIDE - y;
                    if (atlas->receiver[i] < 0 || dx * dx + dy * dy != least) continue;
                    found = plane[here] == lit[atlas->receiver[i]].irradiance[0][0];
                }
                assert_true(found);
                assert_true((plane_of(image, "coverage.A")[here] > 0) == (least == 0));
            }
        free(lit);
        ty_image_destroy(image);
        ty_atlas_destroy(atlas);
    }
    ty_scene_destroy(scene);
    mapped_free(&mesh);
}

static bool within_wall(const ty_bake_receiver* receiver) {
    return receiver->position[2] == 0 && receiver->position[0] > 0.4f && receiver->position[0] < 0.7f;
}

static void walled(const ty_bake_receiver* receiver, int64_t index, ty_bake_light* out) {
    by_chart(receiver, index, out);
    if (receiver->position[2] == 1) { /* no light at all, but nothing good to take */
        out->blocked = 1;
        memset(out->irradiance, 0, sizeof out->irradiance);
    }
    if (receiver->position[2] == 2 && index % 3 == 0) out->irradiance[0][0] = NAN;
    if (!within_wall(receiver)) return;
    out->blocked = 0.9f;
    out->irradiance[0][0] = 1000;
}

static void texels_within_walls_are_filled(void** state) {
    mapped_mesh mesh = four_charts();
    ty_scene* scene = mapped_scene(*state, &mesh, false, true);
    ty_atlas_def def = sized(64);
    def.close_seams = false;
    ty_atlas* atlas = mapped_atlas(scene, &def);
    ty_image* image = image_of(atlas, walled);
    int mended = 0;
    for (int64_t i = 0; i < atlas->count; ++i) {
        const ty_bake_receiver* receiver = &atlas->receivers[i];
        const double light = (double)plane_of(image, "R")[atlas->texels[i]];
        const double x = (double)receiver->position[0], y = (double)receiver->position[1];
        const float samples = plane_of(image, "samples.N")[atlas->texels[i]];
        if (within_wall(receiver)) {
            ++mended;
            assert_true(samples == 0);
            assert_true(light > 1.035 && light < 1.09);
            if (fabs(x - 0.55) > 0.05) assert_close(light, 1 + 0.1 * (x < 0.55 ? 0.4 : 0.7) + 0.01 * y, 0.012);
        } else if (receiver->position[2] == 1) {
            assert_true(light == 0 && samples == 0);
        } else {
            assert_close(light, 1 + (double)receiver->position[2] + 0.1 * x + 0.01 * y,
                         receiver->position[2] == 2 ? 0.01 : 1e-6);
        }
    }
    assert_true(mended > 100);
    ty_image_destroy(image);
    ty_atlas_destroy(atlas);
    ty_scene_destroy(scene);
    mapped_free(&mesh);
}

/* A number that belongs to a place. */
static double noise_at(int64_t index) {
    uint64_t random = (uint64_t)index * 977 + 5;
    uniform(&random);
    return uniform(&random);
}

static void noisy(const ty_bake_receiver* receiver, int64_t index, ty_bake_light* out) {
    const float angle = atan2f(receiver->position[1], receiver->position[0]);
    for (int c = 0; c < 3; ++c) {
        out->irradiance[c][c] = 2 + sinf(angle + (float)c) + cosf(3 * receiver->position[2]);
        out->irradiance[c][c] *= 0.8f + 0.4f * (float)noise_at(index);
        out->fluence[c] = 2 * out->irradiance[c][c];
        for (int a = 0; a < 3; ++a) out->vector_irradiance[c][c][a] = receiver->normal[a] * out->irradiance[c][c];
    }
}

static mapped_mesh cylinder(double right) {
    enum { AROUND = 48, ALONG = 6 };
    mapped_mesh mesh = mapped_nothing();
    for (int i = 0; i <= AROUND; ++i)
        for (int j = 0; j <= ALONG; ++j) {
            const double turn = 2 * 3.14159265358979 * (i % AROUND) / AROUND;
            const uint32_t at = mapped_vertex(&mesh, cos(turn), sin(turn), 2.0 * j / ALONG,
                                              0.1 + (right - 0.1) * i / AROUND, 0.1 + 0.8 * j / ALONG);
            mesh.normals[3 * at] = (float)cos(turn);
            mesh.normals[3 * at + 1] = (float)sin(turn);
        }
    for (uint32_t i = 0; i < AROUND; ++i)
        for (uint32_t j = 0; j < ALONG; ++j) {
            const uint32_t a = i * (ALONG + 1) + j, b = a + ALONG + 1;
            mapped_triangle(&mesh, a, b, b + 1);
            mapped_triangle(&mesh, a, b + 1, a + 1);
        }
    return mesh;
}

typedef struct seam_ends {
    double from[2][2], to[2][2]; /* [side][u, v] */
} seam_ends;

static double seam_difference(const ty_image* image, const seam_ends* seam, const char* channel) {
    double largest = 0;
    for (int i = 0; i <= 1000; ++i) {
        double at[2][2];
        for (int side = 0; side < 2; ++side)
            for (int a = 0; a < 2; ++a)
                at[side][a] = seam->from[side][a] + (seam->to[side][a] - seam->from[side][a]) * i / 1000;
        largest = fmax(largest, fabs(looked_up(image, channel, at[0][0], at[0][1]) -
                                     looked_up(image, channel, at[1][0], at[1][1])));
    }
    return largest;
}

static double mean_of(const ty_image* image, const ty_atlas* atlas, const char* channel) {
    double sum = 0;
    for (int64_t i = 0; i < atlas->count; ++i) sum += (double)plane_of(image, channel)[atlas->texels[i]];
    return sum / (double)atlas->count;
}

/* Bakes with seams open and closed; returns by how much the difference falls. */
static double closed_by(ty_context* context, const mapped_mesh* mesh, const seam_ends* seam, light_fn light) {
    ty_scene* scene = mapped_scene(context, mesh, true, true);
    ty_atlas_def def = sized(96);
    ty_atlas* closing = mapped_atlas(scene, &def);
    def.close_seams = false;
    ty_atlas* leaving = mapped_atlas(scene, &def);
    assert_true(closing->seam_count > 0);
    ty_image *closed = image_of(closing, light), *open = image_of(leaving, light);
    const double before = seam_difference(open, seam, "R"), after = seam_difference(closed, seam, "R");
    const double mean = mean_of(open, leaving, "R");
    print_message("difference %.4f -> %.5f, mean %.5f -> %.5f\n", before, after, mean, mean_of(closed, closing, "R"));
    assert_close(mean_of(closed, closing, "R"), mean, 1e-3 * mean);
    for (int64_t i = 0; i < closing->count; ++i) { /* nothing changes but along the seam */
        const double u = (closing->texels[i] % 96 + 0.5) / 96, v = (closing->texels[i] / 96 + 0.5) / 96;
        bool near = false;
        for (int side = 0; side < 2; ++side)
            for (int k = 0; k <= 200; ++k)
                near |= hypot(u - seam->from[side][0] - (seam->to[side][0] - seam->from[side][0]) * k / 200,
                              v - seam->from[side][1] - (seam->to[side][1] - seam->from[side][1]) * k / 200) < 2.0 / 96;
        const int32_t texel = closing->texels[i];
        if (!near) assert_true(plane_of(open, "R")[texel] == plane_of(closed, "R")[texel]);
        assert_true(plane_of(closed, "R")[texel] >= 0);
        const float length = hypotf(hypotf(plane_of(closed, "L1.GX")[texel], plane_of(closed, "L1.GY")[texel]),
                                    plane_of(closed, "L1.GZ")[texel]);
        assert_true(length <= 1 + 1e-6f);
    }
    ty_image_destroy(open);
    ty_image_destroy(closed);
    ty_atlas_destroy(closing);
    ty_atlas_destroy(leaving);
    ty_scene_destroy(scene);
    return before / after;
}

static void the_seam_of_a_cylinder_is_closed(void** state) {
    const seam_ends seam = {{{0.1, 0.1}, {0.9, 0.1}}, {{0.1, 0.9}, {0.9, 0.9}}};
    mapped_mesh mesh = cylinder(0.9);
    assert_true(closed_by(*state, &mesh, &seam, noisy) > 10);
    mapped_free(&mesh);
}

/* Light that two sides of a fold see unlike, as noise and different places of texels make it. */
static void uneven(const ty_bake_receiver* receiver, int64_t index, ty_bake_light* out) {
    const float side = receiver->position[0] > 1 ? 1.15f : 0.95f;
    (void)index;
    for (int c = 0; c < 3; ++c) out->irradiance[0][c] = side * (1.5f + cosf(2 * receiver->position[1]));
}

/* Two charts that are turned against one another, of different scales. */
static void the_seam_of_a_fold_is_closed(void** state) {
    mapped_mesh mesh = mapped_nothing();
    const double x[2] = {0, 1}, u[2] = {0.05, 0.45}, v[2] = {0.1, 0.6};
    mapped_quad(&mesh, x, all, 0, u, v);
    const uint32_t a = mapped_vertex(&mesh, 1, 0, 0, 0.9, 0.62), b = mapped_vertex(&mesh, 2, 0, 1, 0.9, 0.92);
    const uint32_t c = mapped_vertex(&mesh, 2, 1, 1, 0.55, 0.9), d = mapped_vertex(&mesh, 1, 1, 0, 0.55, 0.6);
    mapped_triangle(&mesh, a, b, c);
    mapped_triangle(&mesh, a, c, d);
    for (int64_t i = 0; i < mesh.vertices; ++i) {
        mesh.normals[3 * i] = -0.38f;
        mesh.normals[3 * i + 2] = 0.92f;
    }
    const seam_ends seam = {{{0.45, 0.1}, {0.9, 0.62}}, {{0.45, 0.6}, {0.55, 0.6}}};
    assert_true(closed_by(*state, &mesh, &seam, uneven) > 10);
    mapped_free(&mesh);
}

/* Edges with different normals on either side stay as they are. */
static void hard_edges_stay(void** state) {
    mapped_mesh mesh = mapped_nothing();
    const double u[2] = {0.05, 0.45}, v[2] = {0.1, 0.6};
    mapped_quad(&mesh, all, all, 0, u, v);
    const uint32_t a = mapped_vertex(&mesh, 1, 0, 0, 0.6, 0.1), b = mapped_vertex(&mesh, 1, 0, 1, 0.9, 0.1);
    const uint32_t c = mapped_vertex(&mesh, 1, 1, 1, 0.9, 0.6), d = mapped_vertex(&mesh, 1, 1, 0, 0.6, 0.6);
    mapped_triangle(&mesh, a, b, c);
    mapped_triangle(&mesh, a, c, d);
    ty_scene* scene = mapped_scene(*state, &mesh, false, true);
    const ty_atlas_def def = sized(32);
    ty_atlas* atlas = mapped_atlas(scene, &def);
    assert_int_equal(atlas->seam_count, 0);
    ty_atlas_destroy(atlas);
    ty_scene_destroy(scene);
    mapped_free(&mesh);
}

static void assert_same_images(const ty_image* a, const ty_image* b) {
    const size_t size = sizeof(float) * (size_t)ty_image_width(a) * (size_t)ty_image_height(a);
    for (int32_t i = 0; i < ty_image_channel_count(a); ++i)
        assert_memory_equal(ty_image_plane_const(a, i), ty_image_plane_const(b, i), size);
}

static void threads_do_not_change_bits(void** state) {
    mapped_mesh mesh = cylinder(0.87);
    ty_context* contexts[2] = {make_context(1), make_context(5)};
    ty_image* images[2];
    (void)state;
    for (int i = 0; i < 2; ++i) {
        ty_scene* scene = mapped_scene(contexts[i], &mesh, true, true);
        const ty_atlas_def def = sized(160);
        ty_atlas* atlas = mapped_atlas(scene, &def);
        images[i] = image_of(atlas, noisy);
        ty_atlas_destroy(atlas);
        ty_scene_destroy(scene);
    }
    assert_same_images(images[0], images[1]);
    for (int i = 0; i < 2; ++i) {
        ty_image_destroy(images[i]);
        ty_context_destroy(contexts[i]);
    }
    mapped_free(&mesh);
}

/* An allocator that fails at one call, and counts what is out. */
typedef struct scarce {
    int64_t calls, fails_at, held, peak;
    int64_t receivers; /* of the last map */
} scarce;

static void* scarce_alloc(void* user, size_t size) {
    scarce* from = user;
    if (++from->calls == from->fails_at) return NULL;
    from->held += (int64_t)size;
    if (from->held > from->peak) from->peak = from->held;
    return aligned_alloc(64, (size + 63) / 64 * 64);
}

static void scarce_free(void* user, void* pointer, size_t size) {
    ((scarce*)user)->held -= (int64_t)size;
    free(pointer);
}

/* An atlas and its image of so many texels along a side, with one allocation failing (0: none); nothing stays taken. */
static ty_result map_with_failure(ty_context* context, const ty_scene* scene, scarce* from, int32_t side,
                                  int64_t fails_at) {
    const ty_atlas_def def = sized(side);
    const int64_t before = from->held;
    ty_atlas* atlas = NULL;
    ty_image* image = NULL;
    ty_bake_light* lit = NULL;
    from->calls = from->peak = 0;
    from->fails_at = fails_at;
    ty_result result = ty_atlas_create(scene, 0, "tube", &def, &atlas);
    if (result == TY_OK) lit = made_up(atlas, noisy);
    if (result == TY_OK) result = ty_atlas_create_image(atlas, lit, &image);
    if (result == TY_OK)
        ty_atlas_receivers(atlas, &from->receivers);
    else
        assert_int_equal(result, TY_ERROR_MEMORY);
    free(lit);
    ty_image_destroy(image);
    ty_atlas_destroy(atlas);
    assert_int_equal(from->held, before);
    ty_take_error(context);
    return result;
}

/* Every allocation may fail, and then nothing stays taken; and those of a large map, which the last run is of, together
 * take about what was said before. */
static void refused_memory_leaves_nothing(void** state) {
    (void)state;
    scarce from = {0};
    ty_context_def context_def = ty_default_context_def();
    context_def.threads = 1;
    context_def.alloc = scarce_alloc;
    context_def.free = scarce_free;
    context_def.alloc_user = &from;
    ty_context* context = NULL;
    assert_int_equal(ty_context_create(&context_def, &context), TY_OK);
    mapped_mesh mesh = cylinder(0.9);
    ty_scene* scene = mapped_scene(context, &mesh, true, true);
    const int64_t before = from.held;
    int64_t fails_at = 1;
    while (map_with_failure(context, scene, &from, 96, fails_at) != TY_OK) ++fails_at;
    assert_true(fails_at > 20);
    const ty_atlas_def def = sized(512);
    assert_int_equal(map_with_failure(context, scene, &from, 512, 0), TY_OK);
    ty_atlas_size size;
    assert_int_equal(ty_atlas_estimate(scene, 0, "tube", &def, &size), TY_OK);
    const double count = (double)from.receivers;
    assert_close(size.texels, count, 0.15 * count);
    const double taken = (double)(from.peak - before) + count * sizeof(ty_bake_light);
    assert_true(taken < size.bytes && taken > 0.7 * size.bytes);
    ty_scene_destroy(scene);
    ty_context_destroy(context);
    mapped_free(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(images_have_all_channels),       cmocka_unit_test(padding_surrounds_charts),
        cmocka_unit_test(texels_within_walls_are_filled), cmocka_unit_test(the_seam_of_a_cylinder_is_closed),
        cmocka_unit_test(the_seam_of_a_fold_is_closed),   cmocka_unit_test(hard_edges_stay),
        cmocka_unit_test(threads_do_not_change_bits),     cmocka_unit_test(refused_memory_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
