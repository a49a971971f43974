/* Grids: creation, sampling, the bounds over bricks, random lookups. */
#include "checks.h"

#include "scene/media/medium.k.h"

#include <stddef.h>

static ty_grid_def sized(int32_t nx, int32_t ny, int32_t nz, const float* values) {
    ty_grid_def def = ty_default_grid_def();
    def.size[0] = nx;
    def.size[1] = ny;
    def.size[2] = nz;
    def.values = values;
    return def;
}

static ty_grid* make_grid(ty_context* context, const ty_grid_def* def) {
    ty_grid* grid = NULL;
    assert_int_equal(ty_grid_create(context, def, &grid), TY_OK);
    return grid;
}

static float* random_values(size_t count, double low, double high) {
    uint64_t random = 11;
    float* values = malloc(count * sizeof *values);
    assert_non_null(values);
    for (size_t i = 0; i < count; ++i) values[i] = (float)uniform_in(&random, low, high);
    return values;
}

/* A grid of random values, half or single, placed or not. */
static ty_grid* random_grid(ty_context* context, const int32_t size[3], ty_grid_type type, bool placed) {
    const size_t count = (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
    float* values = random_values(count, 0.25, 2);
    uint16_t* halves = malloc(count * sizeof *halves);
    assert_non_null(halves);
    for (size_t i = 0; i < count; ++i) halves[i] = ty_float_to_half(values[i]);
    ty_grid_def def = sized(size[0], size[1], size[2], values);
    def.type = type;
    if (type == TY_GRID_F16) def.values = halves;
    def.placed = placed;
    def.background = placed ? -0.5f : 0;
    ty_grid* grid = make_grid(context, &def);
    free(values);
    free(halves);
    return grid;
}

static void wrong_defs_are_refused(void** state) {
    ty_context* context = *state;
    static const bad_field bad[] = {
        {offsetof(ty_grid_def, cookie), FIELD_INT, 1, "ty_default_grid_def"},
        {offsetof(ty_grid_def, size[0]), FIELD_INT, 0, "along x is 0, outside 1..16384"},
        {offsetof(ty_grid_def, size[1]), FIELD_INT, -3, "along y is -3"},
        {offsetof(ty_grid_def, size[2]), FIELD_INT, 16385, "along z is 16385"},
        {offsetof(ty_grid_def, type), FIELD_INT, 2, "type is 2"},
        {offsetof(ty_grid_def, index_to_local.m[5]), FIELD_DOUBLE, 0, "index_to_local"},
        {offsetof(ty_grid_def, index_to_local.m[5]), FIELD_DOUBLE, NAN, "index_to_local"},
        {offsetof(ty_grid_def, index_to_local.m[3]), FIELD_DOUBLE, NAN, "index_to_local"},
        {offsetof(ty_grid_def, index_to_local.m[11]), FIELD_DOUBLE, INFINITY, "index_to_local"},
        {offsetof(ty_grid_def, background), FIELD_FLOAT, NAN, "background"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        ty_grid_def def = sized(2, 2, 2, NULL);
        set_field(&def, &bad[i]);
        ty_grid* grid = NULL;
        assert_int_equal(ty_grid_create(context, &def, &grid), TY_ERROR_ARGUMENT);
        assert_null(grid);
        assert_error(context, bad[i].words);
    }
    assert_int_equal(ty_grid_create(context, NULL, NULL), TY_ERROR_ARGUMENT);
    assert_error(context, "ty_default_grid_def");
}

static void* modest_alloc(void* user, size_t size) {
    size_t* largest = user;
    if (size > *largest) *largest = size;
    return size > 1 << 20 ? NULL : aligned_alloc(64, (size + 63) / 64 * 64);
}

static void modest_free(void* user, void* pointer, size_t size) {
    (void)user;
    (void)size;
    free(pointer);
}

static void too_large_grids_are_refused(void** state) {
    (void)state;
    size_t largest = 0;
    ty_context_def context_def = ty_default_context_def();
    context_def.alloc = modest_alloc;
    context_def.free = modest_free;
    context_def.alloc_user = &largest;
    ty_context* context = NULL;
    assert_int_equal(ty_context_create(&context_def, &context), TY_OK);
    const ty_grid_def def = sized(16384, 16384, 16384, NULL);
    ty_grid* grid = NULL;
    assert_int_equal(ty_grid_create(context, &def, &grid), TY_ERROR_MEMORY);
    assert_error(context, "not enough memory for 16777216.0 MiB");
    assert_true(largest < (size_t)1 << 30); /* refused before anybody was asked for it */
    ty_context_destroy(context);
}

static void values_are_copied_and_described(void** state) {
    float values[24];
    for (int i = 0; i < 24; ++i) values[i] = (float)(i - 5);
    ty_grid_def def = sized(2, 3, 4, values);
    def.index_to_local.m[3] = 7;
    def.placed = true;
    def.background = 0.5f;
    ty_grid* grid = make_grid(*state, &def);
    values[0] = 99;
    const ty_grid_info info = ty_grid_get_info(grid);
    assert_true(info.size[0] == 2 && info.size[1] == 3 && info.size[2] == 4);
    assert_true(info.placed && info.type == TY_GRID_F32);
    assert_true(info.min == -5 && info.max == 18);
    assert_close(info.mean, 6.5, 1e-12);
    assert_close(info.index_to_local.m[3], 7, 0);
    assert_close(info.background, 0.5, 0);
    for (int32_t k = 0; k < 4; ++k)
        for (int32_t j = 0; j < 3; ++j)
            for (int32_t i = 0; i < 2; ++i)
                assert_true(ty_grid_voxel(grid, i, j, k) == (float)(i + 2 * (j + 3 * k) - 5));
    ty_grid_release(grid);
}

static void no_values_are_zeros(void** state) {
    const ty_grid_def def = sized(3, 1, 9, NULL);
    ty_grid* grid = make_grid(*state, &def);
    const ty_grid_info info = ty_grid_get_info(grid);
    assert_true(info.min == 0 && info.max == 0 && info.mean == 0);
    ty_grid_release(grid);
}

static int warnings;

static void count_warnings(void* user, ty_log_level level, const char* text) {
    (void)user;
    warnings += level == TY_LOG_WARNING && strstr(text, " 3 values") != NULL;
}

static void values_that_are_not_finite_count_as_zero(void** state) {
    (void)state;
    ty_context_def context_def = ty_default_context_def();
    context_def.log = count_warnings;
    ty_context* context = NULL;
    assert_int_equal(ty_context_create(&context_def, &context), TY_OK);
    float values[8] = {1, NAN, 2, INFINITY, -INFINITY, 3, 1, 1};
    uint16_t halves[8];
    for (int i = 0; i < 8; ++i) halves[i] = ty_float_to_half(values[i]);
    ty_grid_def def = sized(2, 2, 2, values);
    for (int type = TY_GRID_F32; type <= TY_GRID_F16; ++type) {
        def.type = (ty_grid_type)type;
        def.values = type == TY_GRID_F32 ? (const void*)values : halves;
        warnings = 0;
        ty_grid* grid = make_grid(context, &def);
        assert_int_equal(warnings, 1);
        assert_true(ty_grid_voxel(grid, 1, 0, 0) == 0 && ty_grid_voxel(grid, 1, 1, 0) == 0);
        assert_true(ty_grid_voxel(grid, 0, 0, 1) == 0 && ty_grid_voxel(grid, 1, 0, 1) == 3);
        assert_close(ty_grid_get_info(grid).mean, 1, 1e-12);
        assert_string_equal(ty_take_error(context), "");
        ty_grid_release(grid);
    }
    ty_context_destroy(context);
}

/* The value of a voxel that may lie outside, by the rules in the header. */
static double voxel_or_outside(const ty_grid* grid, const ty_grid_info* info, const int32_t at[3]) {
    int32_t inside[3];
    for (int a = 0; a < 3; ++a) {
        inside[a] = at[a] < 0 ? 0 : at[a] >= info->size[a] ? info->size[a] - 1 : at[a];
        if (inside[a] != at[a] && info->placed) return (double)info->background;
    }
    return (double)ty_grid_voxel(grid, inside[0], inside[1], inside[2]);
}

/* Trilinear interpolation as a sum over eight voxels. */
static double trilinear(const ty_grid* grid, const double index[3]) {
    const ty_grid_info info = ty_grid_get_info(grid);
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        int32_t at[3];
        double weight = 1;
        for (int a = 0; a < 3; ++a) {
            const double base = floor(index[a]), t = index[a] - base;
            at[a] = (int32_t)base + (corner >> a & 1);
            weight *= (corner >> a & 1) != 0 ? t : 1 - t;
        }
        sum += weight * voxel_or_outside(grid, &info, at);
    }
    return sum;
}

static void check_samples(const ty_grid* grid) {
    const ty_grid_info info = ty_grid_get_info(grid);
    uint64_t random = 5;
    for (int i = 0; i < 5000; ++i) {
        double index[3];
        for (int a = 0; a < 3; ++a) index[a] = uniform_in(&random, -3, info.size[a] + 2);
        assert_close(ty_grid_sample(grid, index), trilinear(grid, index), 2e-6);
    }
    for (int32_t i = 0; i < info.size[0]; ++i) {
        const double index[3] = {i, 0, info.size[2] - 1};
        assert_true(ty_grid_sample(grid, index) == ty_grid_voxel(grid, i, 0, info.size[2] - 1));
    }
}

static void samples_are_trilinear(void** state) {
    static const int32_t sizes[][3] = {{9, 4, 17}, {1, 1, 1}, {1, 8, 7}};
    for (size_t s = 0; s < 3; ++s)
        for (int kind = 0; kind < 4; ++kind) {
            ty_grid* grid = random_grid(*state, sizes[s], (kind & 1) != 0 ? TY_GRID_F16 : TY_GRID_F32, kind >= 2);
            check_samples(grid);
            ty_grid_release(grid);
        }
}

static void far_outside_is_background_or_edge(void** state) {
    static const int32_t size[3] = {4, 5, 6};
    static const double far[][3] = {{1e300, 1, 1}, {-INFINITY, 2, 2}, {1, 5, 1}, {2, 2, -1}, {1, -1e9, 7}};
    ty_grid* placed = random_grid(*state, size, TY_GRID_F32, true);
    ty_grid* filling = random_grid(*state, size, TY_GRID_F32, false);
    for (size_t i = 0; i < sizeof far / sizeof *far; ++i) assert_true(ty_grid_sample(placed, far[i]) == -0.5f);
    assert_true(ty_grid_sample(filling, far[0]) == ty_grid_voxel(filling, 3, 1, 1));
    assert_true(ty_grid_sample(filling, far[1]) == ty_grid_voxel(filling, 0, 2, 2));
    assert_true(ty_grid_sample(filling, far[4]) == ty_grid_voxel(filling, 1, 0, 5));
    ty_grid_release(placed);
    ty_grid_release(filling);
}

/* The extremes of the brick that holds a point of [-1, size]^3. */
static const float* extremes_at(const ty_grid_view* view, const double index[3]) {
    int32_t brick[3];
    for (int a = 0; a < 3; ++a) {
        brick[a] = (int32_t)floor((index[a] + 1) / TY_BRICK);
        assert_true(brick[a] >= 0 && brick[a] <= view->bricks[a]);
        if (brick[a] == view->bricks[a]) --brick[a];
    }
    return view->extremes + 2 * (brick[0] + view->bricks[0] * (brick[1] + view->bricks[1] * brick[2]));
}

static void bricks_bound_the_samples(void** state) {
    static const int32_t sizes[][3] = {{19, 8, 7}, {16, 15, 1}, {3, 24, 9}};
    uint64_t random = 6;
    for (int i = 0; i < 12; ++i) {
        ty_grid* grid = random_grid(*state, sizes[i / 4], (i & 1) != 0 ? TY_GRID_F16 : TY_GRID_F32, (i & 2) != 0);
        const ty_grid_view view = ty_grid_get_view(grid);
        for (int n = 0; n < 20000; ++n) {
            double index[3];
            for (int a = 0; a < 3; ++a) index[a] = uniform_in(&random, -1, view.size[a]);
            const float value = ty_grid_sample(grid, index), *bounds = extremes_at(&view, index);
            if (value < bounds[0] - 1e-6f || value > bounds[1] + 1e-6f)
                fail_msg("%g is outside %g..%g", (double)value, (double)bounds[0], (double)bounds[1]);
        }
        ty_grid_release(grid);
    }
}

/* One bright voxel: no brick out of its reach knows of it. */
static void bricks_are_tight(void** state) {
    float* values = random_values(24 * 24 * 24, 0.75, 0.75);
    values[12 + 24 * (12 + 24 * 12)] = 5;
    const ty_grid_def def = sized(24, 24, 24, values);
    ty_grid* grid = make_grid(*state, &def);
    const ty_grid_view view = ty_grid_get_view(grid);
    int bright = 0;
    for (int i = 0; i < view.bricks[0] * view.bricks[1] * view.bricks[2]; ++i) {
        assert_true(view.extremes[2 * i] == 0.75f);
        assert_true(view.extremes[2 * i + 1] == 0.75f || view.extremes[2 * i + 1] == 5);
        bright += view.extremes[2 * i + 1] == 5;
    }
    assert_int_equal(bright, 1);
    ty_grid_release(grid);
    free(values);
}

static void memory_stays_near_the_voxels(void** state) {
    static const int32_t sizes[][3] = {{64, 64, 64}, {33, 65, 40}, {16, 200, 16}};
    for (size_t s = 0; s < 3; ++s)
        for (int type = TY_GRID_F32; type <= TY_GRID_F16; ++type) {
            ty_grid* grid = random_grid(*state, sizes[s], (ty_grid_type)type, false);
            const size_t voxels = (size_t)sizes[s][0] * (size_t)sizes[s][1] * (size_t)sizes[s][2];
            const size_t raw = voxels * (type == TY_GRID_F16 ? 2 : 4), bytes = ty_grid_get_info(grid).bytes;
            assert_true(bytes > raw);
            if ((double)bytes > 1.25 * (double)raw) fail_msg("%zu bytes for %zu", bytes, raw);
            ty_grid_release(grid);
        }
}

static void owners_share_a_grid(void** state) {
    static const int32_t size[3] = {2, 2, 2};
    ty_grid* grid = random_grid(*state, size, TY_GRID_F32, false);
    assert_ptr_equal(ty_grid_retain(grid), grid);
    ty_grid_retain(grid);
    ty_grid_release(grid);
    ty_grid_release(grid);
    assert_true(ty_grid_voxel(grid, 1, 1, 1) > 0);
    ty_grid_release(grid);
    assert_null(ty_grid_retain(NULL));
    ty_grid_release(NULL);
}

static void jittered_lookups_average_to_the_trilinear_value(void** state) {
    static const int32_t size[3] = {5, 6, 7};
    const int count = 20000;
    ty_sobol sobol;
    ty_sobol_matrices(&sobol);
    uint64_t place = 8;
    for (int kind = 0; kind < 4; ++kind) {
        ty_grid* grid = random_grid(*state, size, (kind & 1) != 0 ? TY_GRID_F16 : TY_GRID_F32, kind >= 2);
        const ty_grid_view view = ty_grid_get_view(grid);
        ty_sampler random = ty_sampler_begin(&sobol, 1, (uint64_t)kind, 0);
        for (int p = 0; p < 20; ++p) {
            double index[3], sum = 0, square = 0;
            for (int a = 0; a < 3; ++a) index[a] = uniform_in(&place, -1, size[a]);
            const ty_vec point = ty_vec_make((float)index[0], (float)index[1], (float)index[2]);
            for (int i = 0; i < count; ++i) {
                const double value = (double)ty_grid_jittered(&view, point, &random);
                sum += value;
                square += value * value;
            }
            const double mean = sum / count, variance = fmax(square / count - mean * mean, 0) / count;
            assert_close(mean, ty_grid_sample(grid, index), 4.5 * sqrt(variance) + 1e-5);
        }
        ty_grid_release(grid);
    }
}

/* Along the axis within 0.13 % of the exponential, which is what its voxels are for, and the same across it. */
static void exponentials_fall_off(void** state) {
    ty_context* context = *state;
    for (int32_t axis = 0; axis < 3; ++axis) {
        ty_grid* grid = NULL;
        assert_int_equal(ty_grid_create_exponential(context, axis, -500, 3500, 1200, &grid), TY_OK);
        const int32_t count = ty_grid_get_info(grid).size[axis];
        for (int i = 1; i < 100; ++i) {
            const double share = i / 100.0, height = -500 + 4000 * share;
            double index[3] = {0.3 * i, -0.2 * i, 0.1 * i};
            index[axis] = share * count - 0.5;
            if (index[axis] < 0 || index[axis] > count - 1) continue;
            assert_true(fabs((double)ty_grid_sample(grid, index) / exp(-height / 1200) - 1) < 1.3e-3);
        }
        ty_grid_release(grid);
    }
    ty_grid* grid = NULL;
    assert_int_equal(ty_grid_create_exponential(context, 3, 0, 1, 1, &grid), TY_ERROR_ARGUMENT);
    assert_int_equal(ty_grid_create_exponential(context, 1, 0, 1, 0, &grid), TY_ERROR_ARGUMENT);
    assert_int_equal(ty_grid_create_exponential(context, 1, 1, 1, 1, &grid), TY_ERROR_ARGUMENT);
    assert_int_equal(ty_grid_create_exponential(context, 1, -21, 1, 1, &grid), TY_ERROR_ARGUMENT);
    assert_null(grid);
}

static void end_loan(void* user) {
    ++*(int*)user;
}

/* Borrowed values are read where they lie, stay as they are, and are given back once. */
static void values_are_borrowed(void** state) {
    ty_context* context = *state;
    float values[] = {1, 2, 3, 4, 5, 6, 7, 8};
    int ended = 0;
    ty_grid_def def = sized(2, 2, 2, values);
    def.release = end_loan;
    def.release_user = &ended;
    ty_grid* grid = make_grid(context, &def);
    assert_ptr_equal(ty_grid_values(grid), values);
    assert_float_equal(ty_grid_get_info(grid).max, 8, 0);
    assert_float_equal(ty_grid_voxel(grid, 1, 0, 1), 6, 0);
    ty_grid_retain(grid);
    ty_grid_release(grid);
    assert_int_equal(ended, 0);
    ty_grid_release(grid);
    assert_int_equal(ended, 1);

    values[3] = NAN; /* a copy, and the loan ends at once */
    grid = make_grid(context, &def);
    assert_int_equal(ended, 2);
    assert_ptr_not_equal(ty_grid_values(grid), values);
    assert_float_equal(ty_grid_voxel(grid, 1, 1, 0), 0, 0);
    assert_true(isnan(values[3]));
    ty_grid_release(grid);
    assert_int_equal(ended, 2);

    uint16_t halves[8] = {0x3c00, 0, 0, 0, 0, 0, 0, 0x4000};
    def.values = halves;
    def.type = TY_GRID_F16;
    grid = make_grid(context, &def);
    assert_ptr_equal(ty_grid_values(grid), halves);
    assert_float_equal(ty_grid_get_info(grid).max, 2, 0);
    ty_grid_release(grid);
    assert_int_equal(ended, 3);

    grid = NULL; /* failures give nothing back */
    def.values = (const char*)halves + 1;
    assert_int_equal(ty_grid_create(context, &def, &grid), TY_ERROR_ARGUMENT);
    def.values = NULL;
    assert_int_equal(ty_grid_create(context, &def, &grid), TY_ERROR_ARGUMENT);
    def.values = halves;
    def.size[0] = 0;
    assert_int_equal(ty_grid_create(context, &def, &grid), TY_ERROR_ARGUMENT);
    assert_int_equal(ended, 3);
    assert_null(grid);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wrong_defs_are_refused),
        cmocka_unit_test(too_large_grids_are_refused),
        cmocka_unit_test(values_are_copied_and_described),
        cmocka_unit_test(no_values_are_zeros),
        cmocka_unit_test(values_that_are_not_finite_count_as_zero),
        cmocka_unit_test(samples_are_trilinear),
        cmocka_unit_test(far_outside_is_background_or_edge),
        cmocka_unit_test(bricks_bound_the_samples),
        cmocka_unit_test(bricks_are_tight),
        cmocka_unit_test(memory_stays_near_the_voxels),
        cmocka_unit_test(owners_share_a_grid),
        cmocka_unit_test(jittered_lookups_average_to_the_trilinear_value),
        cmocka_unit_test(exponentials_fall_off),
        cmocka_unit_test(values_are_borrowed),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
