/* Pixels of an image within report.html. */
#ifndef TY_CLI_COMPARE_PAGE_PIXELS_H
#define TY_CLI_COMPARE_PAGE_PIXELS_H

#include <stdio.h>
#include <tyndall/image.h>

/* Writes an element with R, G and B of the whole frame, as means over shrink x shrink pixels: half floats of value *
 * 2^-exponent, three planes; per row the differences from the pixel on the left in zigzag code (0, -1, 1, -2 as 0, 1,
 * 2, 3); all low bytes, then all high bytes; zlib; base64. Attributes: exponent, and the data window (x, y, width,
 * height, in pixels of the frame). Errors: TY_ERROR_MEMORY, TY_ERROR_ARGUMENT (no RGB). */
ty_result cli_write_page_pixels(ty_context* context, FILE* file, const ty_image* image, int32_t shrink);

#endif
