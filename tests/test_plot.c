/* Drawing figures: axes and numbers, colour maps, and how pages turn out. */
#include "checks.h"
#include "files.h"

#include "plot/page.h"

#include <math.h>
#include <string.h>
#include <tyndall/io.h>

static void assert_ticks(const plot_axis* axis, int wanted, const double* expected, int count) {
    double ticks[PLOT_TICKS_MAX];
    assert_int_equal(plot_axis_ticks(axis, wanted, ticks), count);
    for (int i = 0; i < count; ++i) assert_close(ticks[i], expected[i], 1e-9 * fabs(expected[i]));
}

static void linear_axes_end_at_round_numbers(void** state) {
    (void)state;
    const plot_axis errors = plot_linear_axis(0.02, 0.97);
    assert_close(errors.lower, 0, 0);
    assert_close(errors.upper, 1, 1e-12);
    assert_ticks(&errors, 6, (const double[]){0, 0.2, 0.4, 0.6, 0.8, 1}, 6);
    const plot_axis far = plot_linear_axis(101, 107);
    assert_ticks(&far, 6, (const double[]){100, 102, 104, 106, 108}, 5);
    const plot_axis signs = {-50, 50, false};
    assert_ticks(&signs, 5, (const double[]){-50, 0, 50}, 3);
    assert_close(plot_axis_position(&signs, -50), 0, 0);
    assert_close(plot_axis_position(&signs, 25), 0.75, 1e-12);
}

static void logarithmic_axes_have_powers_of_ten(void** state) {
    (void)state;
    const plot_axis wide = plot_log_axis(3e-6, 40);
    assert_close(wide.lower, 2e-6, 1e-15);
    assert_close(wide.upper, 50, 1e-9);
    assert_ticks(&wide, 4, (const double[]){1e-3, 1}, 2);
    const plot_axis narrow = plot_log_axis(2.3, 18);
    assert_ticks(&narrow, 6, (const double[]){2, 5, 10, 20}, 4);
    assert_close(plot_axis_position(&narrow, sqrt(2 * 20)), 0.5, 1e-12);
}

static void axes_of_one_value_have_room(void** state) {
    (void)state;
    double ticks[PLOT_TICKS_MAX];
    const plot_axis axes[] = {plot_linear_axis(7, 7), plot_linear_axis(0, 0), plot_log_axis(7, 7)};
    for (int i = 0; i < 3; ++i) {
        assert_true(axes[i].lower < axes[i].upper);
        assert_in_range(plot_axis_ticks(&axes[i], 6, ticks), 1, PLOT_TICKS_MAX);
    }
}

static void ticks_stay_within_axis_and_array(void** state) {
    (void)state;
    uint64_t seed = 3;
    for (int round = 0; round < 2000; ++round) {
        const bool logarithmic = round % 2 == 1;
        const double least = pow(10, uniform_in(&seed, -12, 12)),
                     most = least * (1 + pow(10, uniform_in(&seed, -6, 9)));
        const plot_axis axis = logarithmic ? plot_log_axis(least, most) : plot_linear_axis(least, most);
        double ticks[PLOT_TICKS_MAX];
        const int count = plot_axis_ticks(&axis, 6, ticks);
        assert_in_range(count, logarithmic ? 1 : 2, PLOT_TICKS_MAX);
        for (int i = 0; i < count; ++i) {
            const double place = plot_axis_position(&axis, ticks[i]);
            assert_true(place > -1e-6 && place < 1 + 1e-6);
            assert_true(i == 0 || ticks[i] > ticks[i - 1]);
        }
        assert_true(plot_axis_position(&axis, least) > -1e-6 && plot_axis_position(&axis, most) < 1 + 1e-6);
    }
}

static void numbers_are_written_as_people_do(void** state) {
    (void)state;
    static const struct {
        double value;
        int digits;
        const char* text;
    } cases[] = {
        {0, 3, "0"},           {0.25, 3, "0.25"},     {-0.5, 3, "-0.5"},    {1234, 2, "1234"},
        {123456, 3, "123456"}, {3e-5, 3, "3×10⁻⁵"},   {1e-12, 3, "10⁻¹²"},  {2.5e7, 3, "2.5×10⁷"},
        {1e6, 3, "10⁶"},       {-1e-4, 3, "-1×10⁻⁴"}, {9.99e-6, 2, "10⁻⁵"}, {0.123456, 3, "0.123"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        char text[PLOT_NUMBER_SIZE];
        plot_format_number(cases[i].value, cases[i].digits, text);
        assert_string_equal(text, cases[i].text);
    }
}

static double luminance(plot_map map, double t) {
    float rgb[3];
    plot_map_color(map, t, rgb);
    for (int c = 0; c < 3; ++c) assert_true(rgb[c] >= 0 && rgb[c] <= 1);
    return 0.2126 * (double)rgb[0] + 0.7152 * (double)rgb[1] + 0.0722 * (double)rgb[2];
}

static void maps_can_be_read_without_colour(void** state) {
    (void)state;
    for (int i = 1; i <= 100; ++i) {
        assert_true(luminance(PLOT_SEQUENTIAL, 0.01 * i) > luminance(PLOT_SEQUENTIAL, 0.01 * (i - 1)));
        const double outer = 0.005 * i, inner = 0.005 * (i - 1);
        assert_true(luminance(PLOT_DIVERGING, 0.5 + outer) < luminance(PLOT_DIVERGING, 0.5 + inner));
        assert_true(luminance(PLOT_DIVERGING, 0.5 - outer) < luminance(PLOT_DIVERGING, 0.5 - inner));
    }
    assert_true(luminance(PLOT_DIVERGING, 0.5) > 0.9);
    assert_true(luminance(PLOT_SEQUENTIAL, -3) == luminance(PLOT_SEQUENTIAL, 0));
    float red[3], blue[3], none[3];
    plot_map_color(PLOT_DIVERGING, 1, red);
    plot_map_color(PLOT_DIVERGING, 0, blue);
    plot_map_color(PLOT_DIVERGING, (double)NAN, none);
    assert_true(red[0] > 2 * red[2] && blue[2] > 2 * blue[0] && none[1] == 1);
}

/* A red picture of a size; its pixel at (1, 2) is green. */
static plot_picture make_red(int32_t width, int32_t height) {
    plot_picture picture = {width, height, calloc((size_t)width * (size_t)height, 3)};
    assert_non_null(picture.rgb8);
    for (int32_t i = 0; i < width * height; ++i) picture.rgb8[3 * i] = 255;
    picture.rgb8[3 * (2 * width + 1)] = 0;
    picture.rgb8[3 * (2 * width + 1) + 1] = 255;
    return picture;
}

static void parts_of_pictures_are_cut_where_asked(void** state) {
    (void)state;
    plot_picture picture = make_red(7, 5), part = {0};
    assert_int_equal(plot_picture_crop(&picture, (const int32_t[]){1, 1, 3, 4}, &part), TY_OK);
    assert_int_equal(part.width, 3);
    assert_int_equal(part.height, 4);
    for (int i = 0; i < 12; ++i) assert_int_equal(part.rgb8[3 * i], i == 3 ? 0 : 255);
    plot_free_picture(&part);
    plot_free_picture(&picture);
}

static void images_and_numbers_become_pictures(void** state) {
    ty_image* image = NULL;
    plot_picture picture = {0};
    assert_int_equal(ty_image_create_rgb(*state, 2, 1, &image), TY_OK);
    ty_image_plane(image, 0)[1] = 1e6f;
    assert_int_equal(plot_picture_of_image(*state, image, 0, &picture), TY_OK);
    assert_int_equal(picture.rgb8[0], 0);
    assert_int_equal(picture.rgb8[3], 255);
    plot_free_picture(&picture);
    ty_image_destroy(image);
    const plot_scale scale = {PLOT_DIVERGING, -2, 2, ""};
    assert_int_equal(plot_picture_of_values(*state, (const float[]){-2, 0, 9}, 3, 1, &scale, &picture), TY_OK);
    assert_true(picture.rgb8[2] > picture.rgb8[0]);
    assert_true(picture.rgb8[3] > 240 && picture.rgb8[4] > 240 && picture.rgb8[5] > 240);
    assert_true(picture.rgb8[6] > picture.rgb8[8]);
    plot_free_picture(&picture);
}

/* A sheet of two by three with one picture, drawn at 40 by 20 pixels, in its lower right cell. */
static plot_sheet make_sheet(void) {
    plot_sheet sheet = {0};
    assert_int_equal(plot_create_sheet(2, 3, 40, &sheet), TY_OK);
    plot_cell* cell = plot_sheet_cell(&sheet, 1, 2);
    cell->picture = make_red(20, 10);
    snprintf(cell->lines[1], PLOT_LABEL_SIZE, "below");
    return sheet;
}

static bool is_red(const ty_image* image, int64_t i) {
    return ty_image_plane_const(image, 0)[i] == 1 && ty_image_plane_const(image, 1)[i] == 0 &&
           ty_image_plane_const(image, 2)[i] == 0;
}

static void pages_show_what_is_put_on_them(void** state) {
    plot_page page;
    plot_sheet sheet = make_sheet();
    assert_int_equal(plot_create_page(*state, &page), TY_OK);
    plot_page_sheet(&page, &sheet);
    assert_int_equal(plot_write_page(&page, "title", "a caption of some words", "page.png"), TY_OK);
    ty_image* image = NULL;
    assert_int_equal(ty_image_read(*state, "page.png", &image), TY_OK);
    const int64_t width = ty_image_width(image), height = ty_image_height(image);
    assert_in_range(width, 3 * 40 + 20, 1000);
    assert_in_range(height, 20, 400);
    int64_t red = 0;
    for (int64_t i = 0; i < width * height; ++i) red += is_red(image, i) ? 1 : 0;
    assert_int_equal(red, 40 * 20 - 2 * 2); /* all of the picture, twice as large, but for its green pixel */
    for (int c = 0; c < 3; ++c) assert_true(ty_image_plane_const(image, c)[0] == 1); /* white paper */
    ty_image_destroy(image);
    plot_free_sheet(&sheet);
    plot_free_page(&page);
}

/* Columns that are not white from a row on, for `rows` rows: the first and the last. */
static void find_drawn(const ty_image* image, int32_t row, int32_t rows, int32_t range[2]) {
    const int32_t width = ty_image_width(image);
    range[0] = width;
    range[1] = -1;
    for (int32_t y = row; y < row + rows; ++y)
        for (int32_t x = 0; x < width; ++x) {
            if (ty_image_plane_const(image, 1)[(int64_t)y * width + x] == 1) continue;
            range[0] = x < range[0] ? x : range[0];
            range[1] = x > range[1] ? x : range[1];
        }
}

/* The picture's last rows tell where its column is. */
static void titles_leave_the_columns_beside_theirs_alone(void** state) {
    plot_page page;
    plot_sheet sheet = {0};
    assert_int_equal(plot_create_sheet(1, 3, 90, &sheet), TY_OK);
    plot_sheet_cell(&sheet, 0, 1)->picture = make_red(20, 10);
    snprintf(sheet.column_titles[1], PLOT_LABEL_SIZE, "a title far longer than its column");
    assert_int_equal(plot_create_page(*state, &page), TY_OK);
    plot_page_sheet(&page, &sheet);
    assert_int_equal(plot_write_page(&page, "", "", "page.png"), TY_OK);
    ty_image* image = NULL;
    assert_int_equal(ty_image_read(*state, "page.png", &image), TY_OK);
    int64_t red = 0;
    while (!is_red(image, red)) ++red;
    const int32_t first = (int32_t)(red / ty_image_width(image));
    int32_t picture[2], title[2];
    find_drawn(image, first + 20, 10, picture);
    find_drawn(image, 0, first, title);
    assert_int_equal(picture[1] - picture[0] + 1, 90);
    assert_in_range(title[0], picture[0], picture[0] + 5);
    assert_in_range(title[1], picture[1] - 5, picture[1] + 1); /* letters are smoothed */
    ty_image_destroy(image);
    plot_free_sheet(&sheet);
    plot_free_page(&page);
}

static void sheets_say_how_much_room_they_take(void** state) {
    plot_canvas* canvas = plot_canvas_create(*state);
    plot_sheet sheet = make_sheet();
    const plot_extent bare = plot_draw_sheet(canvas, 5, 7, &sheet);
    assert_close(bare.width, 3 * 40 + 2 * 10, 0);
    snprintf(sheet.row_titles[0], PLOT_LABEL_SIZE, "row");
    snprintf(sheet.column_titles[2], PLOT_LABEL_SIZE, "column");
    const plot_extent titled = plot_draw_sheet(canvas, 5, 7, &sheet);
    assert_true(titled.width > bare.width && titled.height > bare.height);
    plot_free_sheet(&sheet);
    plot_canvas_destroy(canvas);
}

static void charts_of_nothing_and_of_odd_values_can_be_drawn(void** state) {
    plot_page page;
    plot_chart chart = {.title = "odd", .x_label = "x", .y_label = "y", .y_logarithmic = true, .series_count = 2};
    assert_int_equal(plot_create_page(*state, &page), TY_OK);
    plot_page_charts(&page, &chart, 1);
    plot_add_point(&chart.series[0], 1, 0, 0);
    plot_add_point(&chart.series[0], 2, (double)NAN, 0);
    plot_add_point(&chart.series[0], 3, 5, 9);
    for (int i = 0; i < 2 * PLOT_POINTS_MAX; ++i) plot_add_point(&chart.series[1], i, 1 + i, 0.1);
    assert_int_equal(chart.series[1].count, PLOT_POINTS_MAX);
    plot_page_charts(&page, &chart, 1);
    assert_true(isfinite(page.y) && isfinite(page.width));
    assert_int_equal(plot_write_page(&page, "", "", "charts.png"), TY_OK);
    plot_free_page(&page);
}

static void tables_grow_with_their_text(void** state) {
    plot_canvas* canvas = plot_canvas_create(*state);
    plot_table table;
    assert_int_equal(plot_create_table(3, 2, 1, &table), TY_OK);
    plot_set_cell(&table, 0, 1, "ms");
    plot_set_cell(&table, 2, 1, "%.1f", 2.25);
    const plot_extent narrow = plot_draw_table(canvas, 0, 0, &table);
    plot_set_cell(&table, 1, 0, "a rather long name");
    const plot_extent wide = plot_draw_table(canvas, 0, 0, &table);
    assert_true(wide.width > narrow.width + 60);
    assert_close(wide.height, narrow.height, 0);
    plot_free_table(&table);
    plot_canvas_destroy(canvas);
}

static void pages_that_cannot_be_written_are_reported(void** state) {
    plot_page page;
    assert_int_equal(plot_create_page(*state, &page), TY_OK);
    assert_int_equal(plot_write_page(&page, "title", "", "no/such/folder/page.png"), TY_ERROR_FILE);
    assert_error(*state, "no/such/folder/page.png");
    plot_free_page(&page);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(linear_axes_end_at_round_numbers),
        cmocka_unit_test(logarithmic_axes_have_powers_of_ten),
        cmocka_unit_test(axes_of_one_value_have_room),
        cmocka_unit_test(ticks_stay_within_axis_and_array),
        cmocka_unit_test(numbers_are_written_as_people_do),
        cmocka_unit_test(maps_can_be_read_without_colour),
        cmocka_unit_test(parts_of_pictures_are_cut_where_asked),
        cmocka_unit_test(images_and_numbers_become_pictures),
        cmocka_unit_test(pages_show_what_is_put_on_them),
        cmocka_unit_test(titles_leave_the_columns_beside_theirs_alone),
        cmocka_unit_test(sheets_say_how_much_room_they_take),
        cmocka_unit_test(charts_of_nothing_and_of_odd_values_can_be_drawn),
        cmocka_unit_test(tables_grow_with_their_text),
        cmocka_unit_test(pages_that_cannot_be_written_are_reported),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
