/* Writing .vti files: values at points, the centres of voxels, as 32-bit floats, appended as bytes or as blocks of
 * zlib. Offsets and packed sizes are known later than they stand in the file, and are written over blanks. */
#include "io/volumes/vtk/vtk.h"

#include "base/context.h"
#include "base/number.h"

#include <math.h>
#include <string.h>
#include <zlib.h>

enum { OFFSET_WIDTH = 22, BLOCK = 1 << 18, TEXT_SIZE = 1024 };

typedef struct writer {
    ty_output* output; /* whose commit reports write errors */
    const ty_volume_field* fields;
    int32_t count;
    bool zip, failed;
    ty_grid_info info;
    uint64_t data;     /* position of the first appended byte */
    uint64_t* offsets; /* positions of the offsets of arrays */
    uint64_t* packed;  /* packed sizes of an array's blocks */
    uint64_t block_count;
    size_t filled;
    uint8_t block[BLOCK], packed_block[BLOCK + BLOCK / 256 + 64];
} writer;

static void put(writer* w, const void* bytes, size_t size) {
    ty_output_write(w->output, bytes, size);
}

static void put_text(writer* w, const char* text) {
    put(w, text, strlen(text));
}

static void put_numbers(writer* w, const char* name, const double* numbers, int count) {
    char text[TEXT_SIZE];
    int length = snprintf(text, sizeof text, " %s=\"", name);
    for (int i = 0; i < count; ++i) {
        char number[40];
        ty_format_number(numbers[i], number, sizeof number);
        length += snprintf(text + length, sizeof text - (size_t)length, "%s%s", i > 0 ? " " : "", number);
    }
    put_text(w, text);
    put_text(w, "\"");
}

/* A name within quotes. Control characters, which XML does not allow, become question marks. */
static void put_name(writer* w, const char* name) {
    for (; *name != '\0'; ++name) switch (*name) {
        case '&': put_text(w, "&amp;"); break;
        case '<': put_text(w, "&lt;"); break;
        case '>': put_text(w, "&gt;"); break;
        case '"': put_text(w, "&quot;"); break;
        default: put(w, (unsigned char)*name < ' ' ? "?" : name, 1);
        }
}

static void put_placement(writer* w) {
    const double* m = w->info.index_to_local.m;
    double origin[3], spacing[3], direction[9];
    for (int a = 0; a < 3; ++a) {
        origin[a] = m[4 * a + 3];
        spacing[a] = sqrt(m[a] * m[a] + m[4 + a] * m[4 + a] + m[8 + a] * m[8 + a]);
        for (int r = 0; r < 3; ++r)
            direction[3 * r + a] = spacing[a] > 0 ? m[4 * r + a] / spacing[a] : (double)(r == a);
    }
    put_numbers(w, "Origin", origin, 3);
    put_numbers(w, "Spacing", spacing, 3);
    put_numbers(w, "Direction", direction, 9);
}

static void put_header(writer* w) {
    char extent[TEXT_SIZE];
    snprintf(extent, sizeof extent, "0 %d 0 %d 0 %d", w->info.size[0] - 1, w->info.size[1] - 1, w->info.size[2] - 1);
    put_text(w, "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"");
    put_text(w, __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__ ? "BigEndian" : "LittleEndian");
    put_text(w, "\" header_type=\"UInt64\"");
    if (w->zip) put_text(w, " compressor=\"vtkZLibDataCompressor\"");
    put_text(w, ">\n  <ImageData WholeExtent=\"");
    put_text(w, extent);
    put_text(w, "\"");
    put_placement(w);
    put_text(w, ">\n    <Piece Extent=\"");
    put_text(w, extent);
    put_text(w, "\">\n      <PointData Scalars=\"");
    put_name(w, w->fields[0].name);
    put_text(w, "\">\n");
    for (int32_t i = 0; i < w->count; ++i) {
        put_text(w, "        <DataArray type=\"Float32\" Name=\"");
        put_name(w, w->fields[i].name);
        put_text(w, w->fields[i].components == 3 ? "\" NumberOfComponents=\"3\"" : "\"");
        put_text(w, " format=\"appended\" offset=\"");
        w->offsets[i] = ty_output_position(w->output);
        for (int j = 0; j < OFFSET_WIDTH; ++j) put_text(w, " ");
        put_text(w, "/>\n");
    }
    put_text(w, "      </PointData>\n    </Piece>\n  </ImageData>\n  <AppendedData encoding=\"raw\">\n_");
    w->data = ty_output_position(w->output);
}

static void flush_block(writer* w) {
    uLongf size = sizeof w->packed_block;
    if (w->filled == 0) return;
    if (!w->zip) {
        put(w, w->block, w->filled);
    } else if (compress2(w->packed_block, &size, w->block, w->filled, Z_DEFAULT_COMPRESSION) == Z_OK) {
        put(w, w->packed_block, size);
        w->packed[w->block_count++] = size;
    } else {
        w->failed = true;
    }
    w->filled = 0;
}

static void put_value(writer* w, float value) {
    memcpy(w->block + w->filled, &value, sizeof value);
    w->filled += sizeof value;
    if (w->filled == BLOCK) flush_block(w);
}

static void put_field(writer* w, const ty_volume_field* field, uint64_t total, uint64_t blocks) {
    const uint64_t start = ty_output_position(w->output);
    const uint64_t sizes[3] = {w->zip ? blocks : total, BLOCK, total % BLOCK};
    put(w, sizes, w->zip ? sizeof sizes : sizeof *sizes);
    const uint64_t packed = ty_output_position(w->output);
    if (w->zip) put(w, w->packed, (size_t)blocks * sizeof *w->packed);
    w->block_count = 0;
    for (int32_t k = 0; k < w->info.size[2]; ++k)
        for (int32_t j = 0; j < w->info.size[1]; ++j)
            for (int32_t i = 0; i < w->info.size[0]; ++i)
                for (int32_t c = 0; c < field->components; ++c) put_value(w, ty_grid_voxel(field->grids[c], i, j, k));
    flush_block(w);
    const uint64_t end = ty_output_position(w->output);
    if (w->zip) ty_output_write_at(w->output, w->packed, (size_t)blocks * sizeof *w->packed, packed);
    char text[OFFSET_WIDTH + 1];
    const int length = snprintf(text, sizeof text, "%llu\"", (unsigned long long)(start - w->data));
    ty_output_write_at(w->output, text, (size_t)length, w->offsets[field - w->fields]);
    ty_output_write_at(w->output, "", 0, end);
}

static uint64_t bytes_of(const writer* w, int32_t components) {
    return (uint64_t)w->info.size[0] * (uint64_t)w->info.size[1] * (uint64_t)w->info.size[2] * (uint64_t)components *
           sizeof(float);
}

ty_result ty_vti_write_file(ty_context* context, const ty_volume_field* fields, int32_t count, bool zip,
                            ty_output* output) {
    writer* w = ty_alloc_array(context, 1, sizeof *w, true);
    if (w == NULL) return TY_ERROR_MEMORY;
    w->output = output;
    w->fields = fields;
    w->count = count;
    w->zip = zip;
    w->info = ty_grid_get_info(fields[0].grids[0]);
    const size_t blocks_max = (size_t)(bytes_of(w, 3) / BLOCK + 1);
    w->offsets = ty_alloc_array(context, (size_t)count, sizeof *w->offsets, true);
    w->packed = ty_alloc_array(context, blocks_max, sizeof *w->packed, true);
    ty_result result = w->offsets == NULL || w->packed == NULL ? TY_ERROR_MEMORY : TY_OK;
    if (result == TY_OK) {
        put_header(w);
        for (int32_t i = 0; i < count; ++i) {
            const uint64_t total = bytes_of(w, fields[i].components);
            put_field(w, &fields[i], total, (total + BLOCK - 1) / BLOCK);
        }
        put_text(w, "\n  </AppendedData>\n</VTKFile>\n");
        if (w->failed) result = ty_fail(context, TY_ERROR_MEMORY, "%s: not enough memory to compress", output->path);
    }
    ty_free_array(context, w->offsets, (size_t)count, sizeof *w->offsets);
    ty_free_array(context, w->packed, blocks_max, sizeof *w->packed);
    ty_free_array(context, w, 1, sizeof *w);
    return result;
}
