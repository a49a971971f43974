/* Writing DDS with the header of Direct3D 10 (Microsoft, "Programming Guide for DDS"). */
#include "base/context.h"
#include "io/file.h"
#include "io/textures/textures.h"

#include <string.h>

enum { HEADER = 4 + 124 + 20 };

static const uint32_t dxgi_formats[] = {
    [TY_TEXELS_BC6H] = 95,   [TY_TEXELS_BC6H_SIGNED] = 96, [TY_TEXELS_HALF] = 10, [TY_TEXELS_FLOAT] = 2,
    [TY_TEXELS_RGB9E5] = 67, [TY_TEXELS_RGBE] = 28,        [TY_TEXELS_RGBM] = 28,
};

/* Flags of the header: which fields count. */
enum {
    CAPS = 0x1,
    HEIGHT = 0x2,
    WIDTH = 0x4,
    PITCH = 0x8,
    PIXEL_FORMAT = 0x1000,
    MIPMAP_COUNT = 0x20000,
    LINEAR_SIZE = 0x80000,
    DEPTH = 0x800000,
    FOURCC = 0x4,
    CAPS_COMPLEX = 0x8,
    CAPS_TEXTURE = 0x1000,
    CAPS_MIPMAP = 0x400000,
    CAPS2_VOLUME = 0x200000,
    DIMENSION_2D = 3,
    DIMENSION_3D = 4
};

ty_result ty_write_dds(ty_context* context, const ty_stored_texture* texture, const char* path) {
    const bool blocks = texture->format == TY_TEXELS_BC6H || texture->format == TY_TEXELS_BC6H_SIGNED;
    const bool volume = texture->size[2] > 0, mipmaps = texture->level_count > 1;
    const int32_t row[3] = {texture->size[0], 1, 1}, slice[3] = {texture->size[0], texture->size[1], 1};
    uint8_t head[HEADER] = "DDS ";
    uint8_t* header = head + 4;
    uint8_t* dx10 = head + 128;
    ty_put_le32(header, 124);
    ty_put_le32(header + 4, (uint32_t)(CAPS | HEIGHT | WIDTH | PIXEL_FORMAT | (blocks ? LINEAR_SIZE : PITCH) |
                                       (mipmaps ? MIPMAP_COUNT : 0) | (volume ? DEPTH : 0)));
    ty_put_le32(header + 8, (uint32_t)texture->size[1]);
    ty_put_le32(header + 12, (uint32_t)texture->size[0]);
    ty_put_le32(header + 16, (uint32_t)ty_texel_bytes(texture->format, blocks ? slice : row));
    ty_put_le32(header + 20, (uint32_t)texture->size[2]);
    ty_put_le32(header + 24, (uint32_t)texture->level_count);
    ty_put_le32(header + 72, 32); /* size of the pixel format */
    ty_put_le32(header + 76, FOURCC);
    memcpy(header + 80, "DX10", 4);
    ty_put_le32(header + 104,
                (uint32_t)(CAPS_TEXTURE | (mipmaps ? CAPS_COMPLEX | CAPS_MIPMAP : 0) | (volume ? CAPS_COMPLEX : 0)));
    ty_put_le32(header + 108, volume ? CAPS2_VOLUME : 0);
    ty_put_le32(dx10, dxgi_formats[texture->format]);
    ty_put_le32(dx10 + 4, volume ? DIMENSION_3D : DIMENSION_2D);
    ty_put_le32(dx10 + 12, 1); /* not an array */
    ty_output output;
    const ty_result result = ty_output_open(context, path, &output);
    if (result != TY_OK) return result;
    ty_output_write(&output, head, sizeof head);
    for (int32_t i = 0; i < texture->level_count; ++i)
        ty_output_write(&output, texture->levels[i].bytes, texture->levels[i].count);
    return ty_output_commit(context, &output);
}
