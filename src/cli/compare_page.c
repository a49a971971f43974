/* report.html of `tyndall compare`: a page around what was compared, with its images inside. */
#include "cli/compare_page.h"
#include "cli/difference.h"

#include <stdlib.h>
#include <string.h>

/* The page's frame, compare_page.html. */
extern const char cli_compare_page_text[];

static const char content_mark[] = "<!-- comparison -->";

enum { PNG_SIZE_MAX = 1 << 30 };

/* Text from outside as text of the page, also within quotes. */
static void write_escaped(FILE* file, const char* text) {
    for (const char* c = text; *c != '\0'; ++c) switch (*c) {
        case '&': fputs("&amp;", file); break;
        case '<': fputs("&lt;", file); break;
        case '>': fputs("&gt;", file); break;
        case '"': fputs("&quot;", file); break;
        case '\'': fputs("&#39;", file); break;
        default: fputc((unsigned char)*c < 0x20 || *c == 0x7f ? '?' : *c, file);
        }
}

static void write_base64(FILE* file, const uint8_t* bytes, size_t size) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < size; i += 3) {
        const size_t left = size - i;
        const uint32_t bits =
            (uint32_t)bytes[i] << 16 | (left > 1 ? (uint32_t)bytes[i + 1] << 8 : 0) | (left > 2 ? bytes[i + 2] : 0);
        const char group[4] = {digits[bits >> 18], digits[bits >> 12 & 63], left > 1 ? digits[bits >> 6 & 63] : '=',
                               left > 2 ? digits[bits & 63] : '='};
        fwrite(group, 1, sizeof group, file);
    }
}

/* An image element's source, from a PNG of the folder. */
static ty_result write_source(ty_context* context, FILE* file, const cli_comparison* comparison, const char* prefix,
                              const char* name) {
    char* path = cli_comparison_path(comparison->folder, prefix, name, ".png");
    if (path == NULL) return TY_ERROR_MEMORY;
    uint8_t* bytes = NULL;
    size_t size = 0;
    const ty_result result = ty_bytes_read(context, path, PNG_SIZE_MAX, &bytes, &size);
    free(path);
    if (result != TY_OK) return result;
    fputs(" src=\"data:image/png;base64,", file);
    write_base64(file, bytes, size);
    fputc('"', file);
    ty_bytes_free(context, bytes, size);
    return TY_OK;
}

/* An image where it lies in its frame. */
static ty_result write_placed_image(ty_context* context, FILE* file, const cli_comparison* comparison,
                                    const cli_compared* entry) {
    int32_t frame[4];
    ty_image_get_frame(entry->image, frame);
    fprintf(file, "<img alt=\"%s\" style=\"left:%.6g%%;top:%.6g%%;width:%.6g%%;height:%.6g%%\"", entry->name,
            100.0 * frame[0] / frame[2], 100.0 * frame[1] / frame[3], 100.0 * ty_image_width(entry->image) / frame[2],
            100.0 * ty_image_height(entry->image) / frame[3]);
    const ty_result result = write_source(context, file, comparison, "view_", entry->name);
    fputs(">\n", file);
    return result;
}

static ty_result write_stage(ty_context* context, FILE* file, const cli_comparison* comparison) {
    int32_t frame[4];
    ty_image_get_frame(comparison->reference.image, frame);
    fprintf(file, "<div class=\"stage\" style=\"aspect-ratio:%d/%d\">\n", frame[2], frame[3]);
    ty_result result = write_placed_image(context, file, comparison, &comparison->reference);
    for (int i = 0; i < comparison->count && result == TY_OK; ++i) {
        fprintf(file, "<div class=\"over\" id=\"image-%d\"%s>", i, i > 0 ? " hidden" : "");
        result = write_placed_image(context, file, comparison, &comparison->entries[i]);
        fputs("</div>\n", file);
    }
    fputs("<div class=\"edge\"></div>\n</div>\n", file);
    return result;
}

static void write_controls(FILE* file, const cli_comparison* comparison) {
    fputs("<input type=\"range\" id=\"cut\" min=\"0\" max=\"100\" step=\"0.5\" value=\"50\" "
          "aria-label=\"Where the reference ends\">\n"
          "<div class=\"sides\"><span>reference</span><span id=\"right\"></span></div>\n"
          "<fieldset><legend>Held against the reference</legend>\n",
          file);
    for (int i = 0; i < comparison->count; ++i)
        fprintf(file,
                "<label><input type=\"radio\" name=\"image\" value=\"image-%d\" data-name=\"%s\"%s> %s, relative RMSE "
                "%.3g%%</label>\n",
                i, comparison->entries[i].name, i == 0 ? " checked" : "", comparison->entries[i].name,
                100 * comparison->entries[i].difference.relative_rmse[3]);
    fputs("</fieldset>\n", file);
}

static ty_result write_maps(ty_context* context, FILE* file, const cli_comparison* comparison) {
    ty_result result = TY_OK;
    fputs("<h2>Where they differ</h2>\n<p>Red where brighter than the reference, blue where darker; full colour at 100 "
          "percent of it, or of a tenth of its mean where that is more. Green: not finite.</p>\n<div class=\"maps\">\n",
          file);
    for (int i = 0; i < comparison->count && result == TY_OK; ++i) {
        const char* name = comparison->entries[i].name;
        fprintf(file, "<figure><img alt=\"differences of %s\"", name);
        result = write_source(context, file, comparison, "heat_", name);
        fprintf(file, "><figcaption>%s</figcaption></figure>\n", name);
    }
    fputs("</div>\n", file);
    return result;
}

static void write_amount(FILE* file, double amount) {
    if (amount >= 0)
        fprintf(file, "<td>%.4g</td>", amount);
    else
        fputs("<td></td>", file);
}

static void write_rows(FILE* file, const cli_compared* entry) {
    const ty_difference* d = &entry->difference;
    for (int channel = 0; channel < 4; ++channel) {
        fprintf(file, "<tr%s><td>%s</td><td>%s</td><td>%.6g</td><td>%.6g</td><td>%.6g</td><td>%.6g</td>",
                channel == 3 ? " class=\"all\"" : "", entry->name, cli_difference_names[channel],
                d->mean_ratio[channel], d->rmse[channel], d->relative_rmse[channel], d->rel_mse[channel]);
        write_amount(file, entry->spp);
        write_amount(file, entry->seconds);
        write_amount(file, entry->own_seconds);
        fputs("</tr>\n", file);
    }
}

static void write_table(FILE* file, const cli_comparison* comparison) {
    fputs("<h2>How much</h2>\n<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"Errors\"><table>\n"
          "<thead><tr><th>image</th><th>channel</th><th>mean ratio</th><th>RMSE</th><th>relative RMSE</th>"
          "<th>relMSE</th><th>spp</th><th>seconds</th><th>own seconds</th></tr></thead>\n<tbody>\n",
          file);
    for (int i = 0; i < comparison->count; ++i) write_rows(file, &comparison->entries[i]);
    fputs("</tbody></table></div>\n"
          "<p>Mean ratio: mean / mean of the reference. Relative RMSE: RMSE / mean of the reference. relMSE: mean of "
          "error&sup2; / (reference&sup2; + 0.01 mean&sup2;). Own seconds: without the path-traced image that a method "
          "starts from.</p>\n",
          file);
}

static void write_heading(FILE* file, const cli_comparison* comparison) {
    const cli_compared* reference = &comparison->reference;
    fputs("<h1>", file);
    write_escaped(file, comparison->subject != NULL ? comparison->subject : "Images");
    fputs("</h1>\n<p>Reference: ", file);
    write_escaped(file, reference->source);
    if (reference->spp >= 0) fprintf(file, ", %.6g samples per pixel", reference->spp);
    if (reference->seconds >= 0) fprintf(file, ", %.4g s", reference->seconds);
    fprintf(file, ". Exposure %.3g stops. Tyndall %s.</p>\n", comparison->exposure, ty_version());
}

ty_result cli_print_comparison_page(ty_context* context, FILE* file, const void* user) {
    const cli_comparison* comparison = user;
    const char* mark = strstr(cli_compare_page_text, content_mark);
    fwrite(cli_compare_page_text, 1, (size_t)(mark - cli_compare_page_text), file);
    write_heading(file, comparison);
    ty_result result = write_stage(context, file, comparison);
    write_controls(file, comparison);
    if (result == TY_OK) result = write_maps(context, file, comparison);
    write_table(file, comparison);
    fputs(mark + sizeof content_mark - 1, file);
    return result;
}
