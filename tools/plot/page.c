/* Layout of pages. */
#include "plot/page.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
    MARGIN = 22,
    TITLE_HEIGHT = 34,
    GAP = 16,
    CAPTION_LINE = 19,
    CAPTION_SIZE = 512,
    BAR_WIDTH = 300,
    WIDTH_LEAST = 560
};

static const plot_text title_text = {18, true, PLOT_LEFT, {0.13, 0.13, 0.15}};
static const plot_text caption_text = {13.5, false, PLOT_LEFT, {0.35, 0.35, 0.38}};

ty_result plot_create_page(ty_context* context, plot_page* out) {
    *out = (plot_page){plot_canvas_create(context), MARGIN + TITLE_HEIGHT, WIDTH_LEAST};
    return out->canvas == NULL ? TY_ERROR_MEMORY : TY_OK;
}

void plot_free_page(plot_page* page) {
    plot_canvas_destroy(page->canvas);
    *page = (plot_page){0};
}

static void advance(plot_page* page, plot_extent extent) {
    page->y += extent.height + GAP;
    page->width = fmax(page->width, extent.width);
}

void plot_page_sheet(plot_page* page, const plot_sheet* sheet) {
    advance(page, plot_draw_sheet(page->canvas, MARGIN, page->y, sheet));
}

/* Advances the position for the next of several elements side by side. */
static double beside(const plot_extent* all) {
    return all->width > 0 ? all->width + 2 * GAP : 0;
}

static void add_beside(plot_extent* all, double left, plot_extent one) {
    *all = (plot_extent){left + one.width, fmax(all->height, one.height)};
}

void plot_page_charts(plot_page* page, const plot_chart* charts, int count) {
    plot_extent all = {0};
    for (int i = 0; i < count; ++i) {
        const double left = beside(&all);
        add_beside(&all, left, plot_draw_chart(page->canvas, MARGIN + left, page->y, &charts[i]));
    }
    advance(page, all);
}

void plot_page_lobes(plot_page* page, const plot_lobes* lobes, int count) {
    plot_extent all = {0};
    for (int i = 0; i < count; ++i) {
        const double left = beside(&all);
        add_beside(&all, left, plot_draw_lobes(page->canvas, MARGIN + left, page->y, &lobes[i]));
    }
    advance(page, all);
}

void plot_page_table(plot_page* page, const plot_table* table) {
    advance(page, plot_draw_table(page->canvas, MARGIN, page->y, table));
}

void plot_page_color_bar(plot_page* page, const plot_scale* scale) {
    advance(page, plot_draw_color_bar(page->canvas, MARGIN + 8, page->y, BAR_WIDTH, scale));
}

/* The number of bytes, from the start of a word, that fit into a line; a word longer than a line counts in full. */
static size_t fitting_length(plot_page* page, const char* text) {
    char line[CAPTION_SIZE];
    size_t fitting = 0;
    for (size_t end = strcspn(text, " ");; end += 1 + strcspn(text + end + 1, " ")) {
        snprintf(line, sizeof line, "%.*s", (int)end, text);
        if (fitting > 0 && plot_text_width(page->canvas, &caption_text, line) > page->width) return fitting;
        fitting = end;
        if (text[end] == '\0') return fitting;
    }
}

static void draw_caption(plot_page* page, const char* caption) {
    char line[CAPTION_SIZE];
    for (const char* rest = caption; *rest != '\0';) {
        const size_t length = fitting_length(page, rest);
        snprintf(line, sizeof line, "%.*s", (int)length, rest);
        plot_draw_text(page->canvas, MARGIN, page->y + 12, &caption_text, line);
        page->y += CAPTION_LINE;
        rest += length;
        rest += *rest == ' ' ? 1 : 0;
    }
}

ty_result plot_write_page(plot_page* page, const char* title, const char* caption, const char* path) {
    plot_draw_text(page->canvas, MARGIN, MARGIN + 14, &title_text, title);
    page->width = fmax(page->width, plot_text_width(page->canvas, &title_text, title));
    draw_caption(page, caption);
    return plot_canvas_write(page->canvas, page->width + 2 * MARGIN, page->y + MARGIN - GAP / 2, path);
}
