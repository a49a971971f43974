/* Impulse responses: options, lookups' laws, the cosine product, the file. */
#include "checks.h"
#include "effort.h"
#include "files.h"

#include "method/impulse/tables.h"

#include <math.h>
#include <unistd.h>

static ty_impulse_def small_def(const char* folder) {
    ty_impulse_def def = ty_default_impulse_def();
    def.bounces = 3;
    def.range = 4;
    def.folder = folder;
    return def;
}

/* The fewest bounces that there are, where it is not the numbers that count. */
static ty_impulse_def least_def(const char* folder) {
    ty_impulse_def def = small_def(folder);
    def.bounces = 1;
    return def;
}

static ty_impulse* make(ty_context* context, const ty_impulse_def* def, ty_impulse_stats* stats) {
    ty_impulse* tables = NULL;
    if (ty_impulse_create(context, def, &tables, stats) != TY_OK) fail_msg("%s", ty_take_error(context));
    return tables;
}

/* Made once: sanitizers make that slow. */
static ty_impulse* shared;

static int start_tables(void** state) {
    start_context(state);
    const ty_impulse_def def = small_def("");
    return ty_impulse_create(*state, &def, &shared, NULL) == TY_OK ? 0 : -1;
}

static int stop_tables(void** state) {
    ty_impulse_destroy(shared);
    return stop_context(state);
}

static ty_impulse_response look(ty_impulse_emitter emitter, float sigma_t, float sigma_s, float g, float distance,
                                float cosine, int32_t bounces) {
    const ty_impulse_medium medium = {sigma_t, sigma_s, g};
    ty_impulse_response out;
    ty_impulse_look(shared, emitter, &medium, distance, cosine, bounces, &out);
    return out;
}

static void assert_near(const float* a, const float* b, double factor, double tolerance) {
    for (int l = 0; l < TY_IMPULSE_TERMS; ++l)
        assert_close((double)a[l], factor * (double)b[l], tolerance * factor * (double)b[0]);
}

static void wrong_options_are_refused(void** state) {
    static const bad_field bad[] = {
        {offsetof(ty_impulse_def, cookie), FIELD_INT, 1, "ty_default_impulse_def"},
        {offsetof(ty_impulse_def, bounces), FIELD_INT, 0, "impulse.bounces"},
        {offsetof(ty_impulse_def, bounces), FIELD_INT, 65, "impulse.bounces"},
        {offsetof(ty_impulse_def, range), FIELD_DOUBLE, 0.5, "impulse.range"},
        {offsetof(ty_impulse_def, range), FIELD_DOUBLE, 101, "impulse.range"},
        {offsetof(ty_impulse_def, range), FIELD_DOUBLE, NAN, "impulse.range"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; ++i) {
        ty_impulse_def def = small_def("");
        ty_impulse* tables = NULL;
        set_field(&def, &bad[i]);
        assert_int_equal(ty_impulse_create(*state, &def, &tables, NULL), TY_ERROR_ARGUMENT);
        assert_null(tables);
        assert_error(*state, bad[i].words);
    }
    const ty_impulse_def def = small_def("");
    assert_int_equal(ty_impulse_create(*state, &def, NULL, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "out is NULL");
}

/* A medium that is twice as dense is one where everything is half as far apart: Sec. 4.3. */
static void media_are_told_apart_by_scale_alone(void** state) {
    (void)state;
    for (int emitter = 0; emitter < 3; ++emitter) {
        const ty_impulse_response one = look((ty_impulse_emitter)emitter, 1, 0.7f, 0.2f, 1.5f, 0.4f, 3);
        const ty_impulse_response dense = look((ty_impulse_emitter)emitter, 8, 5.6f, 0.2f, 1.5f / 8, 0.4f, 3);
        const double factor = emitter == TY_IMPULSE_DIRECTIONAL ? 1 : 64;
        assert_near(dense.single, one.single, factor, 1e-5);
        assert_near(dense.multiple, one.multiple, factor, 1e-5);
        assert_close((double)dense.shift, (double)one.shift, 1e-6);
    }
}

static void albedo_weighs_every_bounce(void** state) {
    (void)state;
    const float albedo = 0.6f;
    const ty_impulse_response white = look(TY_IMPULSE_POINT, 1, 1, 0, 1, 1, 3),
                              two = look(TY_IMPULSE_POINT, 1, 1, 0, 1, 1, 2);
    const ty_impulse_response grey = look(TY_IMPULSE_POINT, 1, albedo, 0, 1, 1, 3);
    for (int l = 0; l < TY_IMPULSE_TERMS; ++l) {
        const float more = albedo * albedo * (two.multiple[l] + albedo * (white.multiple[l] - two.multiple[l]));
        assert_close((double)grey.single[l], (double)(albedo * white.single[l]), 1e-6);
        assert_close((double)grey.multiple[l], (double)more, 1e-6);
    }
}

static void bounces_that_do_not_count_are_not_there(void** state) {
    (void)state;
    const ty_impulse_response once = look(TY_IMPULSE_AREA, 1, 1, 0, 1, 0.5f, 1),
                              none = look(TY_IMPULSE_AREA, 1, 1, 0, 1, 0.5f, 0);
    const ty_impulse_response all = look(TY_IMPULSE_AREA, 1, 1, 0, 1, 0.5f, 3),
                              more = look(TY_IMPULSE_AREA, 1, 1, 0, 1, 0.5f, 99);
    assert_true(once.single[0] > 0 && all.multiple[0] > 0);
    for (int l = 0; l < TY_IMPULSE_TERMS; ++l) {
        assert_true(once.multiple[l] == 0 && none.single[l] == 0 && none.multiple[l] == 0);
        assert_true(more.multiple[l] == all.multiple[l] && once.single[l] == all.single[l]);
    }
}

/* Nothing scatters where there is no medium, and no lookup gives what is no number. */
static void any_lookup_is_finite(void** state) {
    (void)state;
    static const float distances[] = {0, 1e-30f, 1e-4f, 1, 4, 50, 1e6f, INFINITY};
    static const float sigmas[] = {0, 1e-20f, 1e-3f, 1, 1e3f};
    for (int emitter = 0; emitter < 3; ++emitter)
        for (size_t d = 0; d < sizeof distances / sizeof distances[0]; ++d)
            for (size_t s = 0; s < sizeof sigmas / sizeof sigmas[0]; ++s)
                for (float g = -2; g <= 2; g += 0.5f)
                    for (float cosine = -1; cosine <= 2; cosine += 0.5f) {
                        const ty_impulse_response r =
                            look((ty_impulse_emitter)emitter, sigmas[s], sigmas[s], g, distances[d], cosine, 3);
                        assert_true(isfinite(r.shift));
                        for (int l = 0; l < TY_IMPULSE_TERMS; ++l) {
                            assert_true(isfinite(r.single[l]) && isfinite(r.multiple[l]));
                            if (sigmas[s] == 0) assert_true(r.single[l] == 0 && r.multiple[l] == 0);
                        }
                    }
}

/* Near a point light, radiance scattered once falls with distance, not its square. */
static void the_nearest_follow_their_law(void** state) {
    (void)state;
    const ty_impulse_response near = look(TY_IMPULSE_POINT, 1, 1, 0, 1e-4f, 1, 1);
    const double pi = 3.14159265358979, fluence = sqrt(4 * pi) * (double)near.single[0];
    assert_close(fluence / (pi * pi / 4 / 1e-4), 1, 0.01);
    const ty_impulse_response far = look(TY_IMPULSE_POINT, 1, 1, 0, 5, 1, 1),
                              last = look(TY_IMPULSE_POINT, 1, 1, 0, 4, 1, 1);
    assert_close((double)(far.single[0] / last.single[0]), 0.8 * exp(-1), 0.01);
}

/* Appendix A, against summing over the sphere. */
static void the_cosine_product_is_an_integral(void** state) {
    (void)state;
    enum { STEPS = 400 };
    uint64_t seed = 7;
    float zonal[TY_IMPULSE_TERMS];
    for (int l = 0; l < TY_IMPULSE_TERMS; ++l) zonal[l] = (float)uniform_in(&seed, -1, 1);
    for (int k = 0; k <= 8; ++k) {
        const double pi = 3.14159265358979323846, lean = pi * k / 8;
        double sum = 0;
        for (int i = 0; i < STEPS; ++i)
            for (int j = 0; j < STEPS; ++j) {
                const double z = -1 + (2 * i + 1.0) / STEPS, phi = pi * (j + 0.5) / STEPS, side = sqrt(1 - z * z);
                const double cosine = cos(lean) * z + sin(lean) * side * cos(phi);
                if (cosine <= 0) continue;
                double value = 0, before = 0, last = 1;
                for (int l = 0; l < TY_IMPULSE_TERMS; ++l) {
                    value += (double)zonal[l] * sqrt((2 * l + 1) / (4 * pi)) * last;
                    const double next = ((2 * l + 1) * z * last - l * before) / (l + 1);
                    before = last;
                    last = next;
                }
                sum += value * cosine;
            }
        sum *= 2.0 / STEPS * 2 * pi / STEPS;
        assert_close((double)ty_impulse_irradiance(zonal, (float)cos(lean)), sum, 2e-3);
    }
    const float even[TY_IMPULSE_TERMS] = {3.5449077f}; /* radiance 1 from everywhere */
    assert_close((double)ty_impulse_irradiance(even, 0.3f), 3.14159265, 1e-5);
}

static void bins_are_what_lookups_find(void** state) {
    for (int emitter = 0; emitter < 3; ++emitter)
        for (int g = -1; g <= 1; ++g)
            for (int bin = 0; bin < TY_IMPULSE_DISTANCES; bin += 17) {
                const int32_t angle = emitter == TY_IMPULSE_AREA ? bin % TY_IMPULSE_ANGLES : 0;
                double distance;
                float zonal[TY_IMPULSE_TERMS];
                assert_int_equal(
                    ty_impulse_bin(shared, (ty_impulse_emitter)emitter, 1, g, angle, bin, &distance, zonal), TY_OK);
                const ty_impulse_response found = look((ty_impulse_emitter)emitter, 1, 1, 0.5f * (float)g,
                                                       (float)distance, ty_impulse_cosines[angle], 1);
                assert_near(found.single, zonal, 1, 1e-4);
            }
    double distance;
    float zonal[TY_IMPULSE_TERMS];
    static const int32_t bad[][5] = {{3, 1, 0, 0, 0},  {0, 0, 0, 0, 0},   {0, 4, 0, 0, 0},
                                     {0, 2, 1, 0, 0},  {0, 1, 2, 0, 0},   {0, 1, 0, 1, 0},
                                     {2, 1, 0, 16, 0}, {0, 1, 0, 0, 256}, {0, 1, 0, 0, -1}};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; ++i) {
        const int32_t* b = bad[i];
        assert_int_equal(ty_impulse_bin(shared, (ty_impulse_emitter)b[0], b[1], b[2], b[3], b[4], &distance, zonal),
                         TY_ERROR_ARGUMENT);
        assert_error(*state, "ty_impulse_bin");
    }
}

/* ---- the file ---- */

static void tables_are_kept_and_found(void** state) {
    const ty_impulse_def def = least_def("impulse_cache/new");
    ty_impulse_stats stats = ty_default_impulse_stats();
    remove("impulse_cache/new/impulse-1-4000.tables");
    ty_impulse* first = make(*state, &def, &stats);
    assert_true(stats.built);
    assert_string_equal(stats.path, "impulse_cache/new/impulse-1-4000.tables");
    ty_impulse* again = make(*state, &def, &stats);
    assert_false(stats.built);
    assert_int_equal(again->count, first->count);
    assert_memory_equal(again->values, first->values, first->count * sizeof *first->values);
    ty_impulse_destroy(again);
    size_t size;
    uint8_t* bytes = get_file(stats.path, &size);
    /* Of another version, damaged and cut short: not taken, but made anew, and whole again afterwards. */
    static const size_t places[] = {8, 5000, 5000};
    for (size_t i = 0; i < sizeof places / sizeof places[0]; ++i) {
        bytes[places[i]] ^= 1;
        put_file(stats.path, bytes, i == 2 ? size / 2 : size);
        bytes[places[i]] ^= 1;
        assert_false(ty_impulse_load(first, stats.path));
    }
    ty_impulse_destroy(first);
    if (numbers_count()) { /* sanitizers have seen all of it above */
        ty_impulse_destroy(make(*state, &def, &stats));
        assert_true(stats.built);
        assert_file_holds(stats.path, bytes, size);
    }
    assert_string_equal(ty_take_error(*state), "");
    free(bytes);
}

static void folders_that_cannot_be_written_are_a_warning(void** state) {
    leave_to_full_runs(); /* a table's whole making */
    put_file("impulse_no_folder", "x", 1);
    const ty_impulse_def def = least_def("impulse_no_folder");
    ty_impulse_stats stats = ty_default_impulse_stats();
    ty_impulse_destroy(make(*state, &def, &stats));
    assert_true(stats.built);
    assert_string_equal(stats.path, "");
    assert_string_equal(ty_take_error(*state), "");
}

static void files_hold_numbers_of_the_same_tables(void** state) {
    const size_t size = ty_impulse_file_size(shared);
    uint8_t* bytes = malloc(size);
    assert_non_null(bytes);
    ty_impulse* other = NULL;
    ty_impulse_def def = small_def("");
    assert_int_equal(ty_impulse_allocate(*state, &def, &other), TY_OK);
    ty_impulse_pack(shared, bytes);
    assert_null(ty_impulse_unpack(other, bytes, size));
    assert_non_null(ty_impulse_unpack(other, bytes, size - 1));
    assert_non_null(ty_impulse_unpack(other, bytes, 3));
    const float wrong = NAN;
    memcpy(bytes + size - sizeof wrong, &wrong, sizeof wrong);
    assert_string_equal(ty_impulse_unpack(other, bytes, size), "it is damaged");
    ty_impulse_seal(bytes, size);
    assert_string_equal(ty_impulse_unpack(other, bytes, size), "it holds what is no number");
    ty_impulse_destroy(other);
    def.range = 5;
    assert_int_equal(ty_impulse_allocate(*state, &def, &other), TY_OK);
    ty_impulse_pack(shared, bytes);
    assert_string_equal(ty_impulse_unpack(other, bytes, size), "it has other bounces or another range");
    ty_impulse_destroy(other);
    free(bytes);
}

/* ---- making them ---- */

static void threads_do_not_matter(void** state) {
    skip_under_address_sanitizer();
    (void)state;
    ty_context* alone = make_context(1);
    const ty_impulse_def def = small_def("");
    ty_impulse* tables = make(alone, &def, NULL);
    assert_memory_equal(tables->values, shared->values, shared->count * sizeof *shared->values);
    ty_impulse_destroy(tables);
    ty_context_destroy(alone);
}

static bool stop_half_way(void* user, const ty_progress* progress) {
    double* last = user;
    assert_true(progress->fraction >= *last && progress->fraction <= 1);
    *last = progress->fraction;
    return progress->fraction < 0.5;
}

static bool stop_at_once(void* user, const ty_progress* progress) {
    (void)user;
    (void)progress;
    return false;
}

static void making_can_be_cancelled(void** state) {
    skip_under_sanitizers(); /* little_memory_is_told stops it, too */
    double last = 0;
    ty_impulse_def def = least_def("");
    ty_impulse* tables = NULL;
    def.progress = stop_half_way;
    def.progress_user = &last;
    assert_int_equal(ty_impulse_create(*state, &def, &tables, NULL), TY_CANCELLED);
    assert_null(tables);
    assert_true(last >= 0.5 && last < 0.7);
}

static void little_memory_is_told(void** state) {
    (void)state;
    for (int64_t refused = 0; refused < 12; ++refused) {
        strict_memory memory = {.limit = (size_t)1 << 30, .until_refusal = -1};
        ty_context* context = strict_context(&memory);
        const ty_impulse_def def = least_def("");
        ty_impulse* tables = NULL;
        memory.until_refusal = refused;
        ty_impulse_def cancelled = def; /* what has all its memory need not be made */
        cancelled.progress = stop_at_once;
        const ty_result result = ty_impulse_create(context, &cancelled, &tables, NULL);
        assert_true(result == TY_ERROR_MEMORY || (result == TY_CANCELLED && refused > 8));
        ty_context_destroy(context);
        assert_int_equal(memory.used, 0);
        if (result == TY_CANCELLED) return;
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wrong_options_are_refused),
        cmocka_unit_test(media_are_told_apart_by_scale_alone),
        cmocka_unit_test(albedo_weighs_every_bounce),
        cmocka_unit_test(bounces_that_do_not_count_are_not_there),
        cmocka_unit_test(any_lookup_is_finite),
        cmocka_unit_test(the_nearest_follow_their_law),
        cmocka_unit_test(the_cosine_product_is_an_integral),
        cmocka_unit_test(bins_are_what_lookups_find),
        cmocka_unit_test(tables_are_kept_and_found),
        cmocka_unit_test(folders_that_cannot_be_written_are_a_warning),
        cmocka_unit_test(files_hold_numbers_of_the_same_tables),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(making_can_be_cancelled),
        cmocka_unit_test(little_memory_is_told),
    };
    return cmocka_run_group_tests(tests, start_tables, stop_tables);
}
