/* Images in a row, with a label above each. */
#include "cli/images/side_by_side.h"

#include <math.h>
#include <string.h>

enum { GLYPH_WIDTH = 3, GLYPH_HEIGHT = 5, GAP = 4 };

/* A 3 x 5 bitmap font: an octal digit per row, from the top, its highest bit on the left. */
static const struct {
    char letter;
    uint16_t rows;
} glyphs[] = {
    {'A', 025755}, {'B', 065656}, {'C', 034443}, {'D', 065556}, {'E', 074647}, {'F', 074644}, {'G', 034553},
    {'H', 055755}, {'I', 072227}, {'J', 011152}, {'K', 055655}, {'L', 044447}, {'M', 057755}, {'N', 065555},
    {'O', 025552}, {'P', 065644}, {'Q', 025563}, {'R', 065655}, {'S', 034216}, {'T', 072222}, {'U', 055557},
    {'V', 055552}, {'W', 055775}, {'X', 055255}, {'Y', 055222}, {'Z', 071247}, {'0', 075557}, {'1', 026227},
    {'2', 061247}, {'3', 061216}, {'4', 055711}, {'5', 074616}, {'6', 034652}, {'7', 071222}, {'8', 025252},
    {'9', 025316}, {'-', 000700}, {'.', 000002}, {'_', 000007}, {'%', 051245}, {':', 002020}, {'+', 002720},
    {'/', 011244}, {' ', 000000},
};

static const uint16_t unknown_glyph = 061202; /* a question mark */

static uint16_t find_glyph(char letter) {
    const char capital = letter >= 'a' && letter <= 'z' ? (char)(letter - 'a' + 'A') : letter;
    for (size_t i = 0; i < sizeof glyphs / sizeof *glyphs; ++i)
        if (glyphs[i].letter == capital) return glyphs[i].rows;
    return unknown_glyph;
}

/* The layout, pixels. */
typedef struct layout {
    int32_t width, height; /* size of a panel without its label */
    int32_t dot;           /* side of a font pixel */
    int32_t top;           /* height of a label */
} layout;

static layout choose_layout(const cli_panel* panels) {
    int32_t frame[4];
    ty_image_get_frame(panels[0].image, frame);
    const int32_t dot = frame[2] >= 320 ? 3 : frame[2] >= 128 ? 2 : 1;
    return (layout){.width = frame[2], .height = frame[3], .dot = dot, .top = dot * (GLYPH_HEIGHT + 4)};
}

static void fill_rectangle(ty_image* image, int32_t x0, int32_t y0, int32_t width, int32_t height, float value) {
    for (int c = 0; c < 3; ++c)
        for (int32_t y = y0; y < y0 + height; ++y) {
            float* row = ty_image_plane(image, c) + (size_t)y * (size_t)ty_image_width(image);
            for (int32_t x = x0; x < x0 + width; ++x) row[x] = value;
        }
}

static void draw_label(ty_image* image, const layout* l, int32_t x0, const char* text, float white) {
    const int32_t advance = l->dot * (GLYPH_WIDTH + 1);
    int32_t x = x0 + 2 * l->dot;
    for (const char* letter = text; *letter != '\0' && x + advance <= x0 + l->width; ++letter, x += advance) {
        const uint16_t rows = find_glyph(*letter);
        for (int row = 0; row < GLYPH_HEIGHT; ++row)
            for (int column = 0; column < GLYPH_WIDTH; ++column) {
                const int bit = 3 * (GLYPH_HEIGHT - 1 - row) + GLYPH_WIDTH - 1 - column;
                if ((rows >> bit & 1) != 0)
                    fill_rectangle(image, x + column * l->dot, (row + 2) * l->dot, l->dot, l->dot, white);
            }
    }
}

static void draw_pixels(ty_image* image, const layout* l, int32_t x0, const ty_image* from) {
    const int32_t width = ty_image_width(from), height = ty_image_height(from);
    int32_t frame[4];
    const float* planes[3];
    ty_image_get_frame(from, frame);
    if (!ty_image_rgb_planes(from, planes)) return;
    for (int c = 0; c < 3; ++c)
        for (int32_t y = 0; y < height; ++y) {
            if (frame[1] + y < 0 || frame[1] + y >= l->height) continue;
            float* row = ty_image_plane(image, c) + (size_t)(l->top + frame[1] + y) * (size_t)ty_image_width(image);
            for (int32_t x = 0; x < width; ++x)
                if (frame[0] + x >= 0 && frame[0] + x < l->width)
                    row[x0 + frame[0] + x] = planes[c][(size_t)y * (size_t)width + (size_t)x];
        }
}

ty_result cli_write_side_by_side(ty_context* context, const cli_panel* panels, int count, double exposure,
                                 const char* path) {
    const layout l = choose_layout(panels);
    const int64_t width = (int64_t)count * (l.width + GAP) - GAP;
    ty_image* image = NULL;
    ty_result result =
        ty_image_create_rgb(context, width > INT32_MAX ? INT32_MAX : (int32_t)width, l.top + l.height, &image);
    if (result != TY_OK) return result;
    /* The tone curve maps this value to white at any exposure. */
    const float white = (float)fmin(1e4 * exp2(-exposure), 1e30);
    for (int i = 0; i < count; ++i) {
        const int32_t x0 = i * (l.width + GAP);
        draw_pixels(image, &l, x0, panels[i].image);
        draw_label(image, &l, x0, panels[i].label, white);
    }
    result = ty_image_write_png(context, image, exposure, TY_TONE_FILMIC, path);
    ty_image_destroy(image);
    return result;
}
