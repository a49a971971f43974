/* report.html of `tyndall compare`: a self-contained page with the compared data and the scripts that display it. */
#define _POSIX_C_SOURCE 200809L
#include "cli/compare/page.h"
#include "cli/compare/files.h"
#include "cli/compare/page_pixels.h"
#include "cli/text/text_file.h"

#include <stdlib.h>
#include <string.h>

/* The files of the page, page.*; the scripts follow each other in one element. */
extern const char cli_page_html_text[], cli_page_css_text[], cli_page_color_maps_js_text[], cli_page_pixels_js_text[],
    cli_page_viewer_js_text[], cli_page_magnifier_js_text[], cli_page_charts_js_text[], cli_page_main_js_text[];

/* Wider frames are downsampled for the page. */
enum { WIDTH_MAX = 1280 };

/* Escapes untrusted text for the page. */
static void write_escaped(FILE* file, const char* text) {
    for (const char* c = text; *c != '\0'; ++c) switch (*c) {
        case '&': fputs("&amp;", file); break;
        case '<': fputs("&lt;", file); break;
        case '>': fputs("&gt;", file); break;
        default: fputc((unsigned char)*c < 0x20 || *c == 0x7f ? '?' : *c, file);
        }
}

static void print_data(FILE* file, const cli_comparison* comparison, int shrink) {
    int32_t frame[4];
    ty_image_get_frame(comparison->reference.image, frame);
    json_writer json = json_begin(file);
    json_open_object(&json, NULL);
    json_text(&json, "version", ty_version());
    json_int(&json, "width", frame[2]);
    json_int(&json, "height", frame[3]);
    json_int(&json, "shrink", shrink);
    cli_comparison_json(&json, comparison);
    cli_comparison_scene_json(&json, comparison);
    json_close_object(&json);
}

/* The members of errors.json and the frame. A < would end the element; in JSON it occurs in strings only, where it is
 * escaped. */
static ty_result write_data(FILE* file, const cli_comparison* comparison, int shrink) {
    cli_text memory;
    if (!cli_text_open(&memory)) return TY_ERROR_MEMORY;
    print_data(memory.file, comparison, shrink);
    char* text = cli_text_close(&memory);
    if (text == NULL) return TY_ERROR_MEMORY;
    fputs("<script type=\"application/json\" id=\"comparison\">\n", file);
    for (size_t i = 0; i < memory.size; ++i)
        if (text[i] == '<')
            fputs("\\u003c", file);
        else
            fputc(text[i], file);
    fputs("</script>\n", file);
    free(text);
    return TY_OK;
}

static ty_result write_all_data(ty_context* context, FILE* file, const cli_comparison* comparison) {
    int32_t frame[4];
    ty_image_get_frame(comparison->reference.image, frame);
    const int32_t shrink = (frame[2] + WIDTH_MAX - 1) / WIDTH_MAX;
    ty_result result = write_data(file, comparison, shrink);
    if (result == TY_OK) result = cli_write_page_pixels(context, file, comparison->reference.image, shrink);
    for (int i = 0; i < comparison->count && result == TY_OK; ++i)
        result = cli_write_page_pixels(context, file, comparison->entries[i].image, shrink);
    return result;
}

/* Writes a module as a plain script, of which nothing is exported. */
static void write_module(FILE* file, const char* text) {
    static const char word[] = "export ";
    for (const char* found; (found = strstr(text, word)) != NULL; text = found + strlen(word))
        fwrite(text, 1, (size_t)(found - text), file);
    fputs(text, file);
}

static void write_scripts(FILE* file) {
    const char* const parts[] = {cli_page_pixels_js_text, cli_page_viewer_js_text, cli_page_magnifier_js_text,
                                 cli_page_charts_js_text, cli_page_main_js_text};
    fputs("\"use strict\";\n", file);
    write_module(file, cli_page_color_maps_js_text);
    for (size_t i = 0; i < sizeof parts / sizeof parts[0]; ++i) fputs(parts[i], file);
}

ty_result cli_print_comparison_page(ty_context* context, FILE* file, const void* user) {
    static const char* const marks[] = {"<!-- title -->", "/* style */", "<!-- data -->", "/* script */"};
    const cli_comparison* comparison = user;
    const char* rest = cli_page_html_text;
    ty_result result = TY_OK;
    for (int i = 0; i < 4 && result == TY_OK; ++i) {
        const char* mark = strstr(rest, marks[i]);
        fwrite(rest, 1, (size_t)(mark - rest), file);
        rest = mark + strlen(marks[i]);
        if (i == 0) write_escaped(file, comparison->subject != NULL ? comparison->subject : "Images");
        if (i == 1) fputs(cli_page_css_text, file);
        if (i == 2) result = write_all_data(context, file, comparison);
        if (i == 3) write_scripts(file);
    }
    fputs(rest, file);
    return result;
}
