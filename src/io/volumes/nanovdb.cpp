/* The only file that includes NanoVDB's C++ library, for writing. No exception leaves it. */
extern "C" {
#include "base/context.h"
#include "io/file.h"
}

#include "io/volumes/nanovdb.h"

#include <nanovdb/util/GridBuilder.h>
#include <nanovdb/util/IO.h>
#include <zlib.h>

#include <cstring>
#include <memory>
#include <new>
#include <sstream>

namespace {

nanovdb::Map make_map(const ty_affine& map) {
    ty_affine inverse = ty_affine_identity();
    ty_affine_invert(&map, &inverse);
    nanovdb::Map made;
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) {
            made.mMatD[3 * r + c] = map.m[4 * r + c];
            made.mMatF[3 * r + c] = float(map.m[4 * r + c]);
            made.mInvMatD[3 * r + c] = inverse.m[4 * r + c];
            made.mInvMatF[3 * r + c] = float(inverse.m[4 * r + c]);
        }
        made.mVecD[r] = map.m[4 * r + 3];
        made.mVecF[r] = float(map.m[4 * r + 3]);
    }
    made.mTaperD = 1;
    made.mTaperF = 1;
    return made;
}

/* Segment header and metadata, then the grid as it is stored. */
void write_file(nanovdb::io::Segment& segment, const uint8_t* stored, uint64_t size, ty_output* output) {
    segment.meta[0].fileSize = size;
    std::ostringstream head;
    head.exceptions(std::ios::badbit);
    segment.write(head);
    const std::string text = head.str();
    ty_output_write(output, text.data(), text.size());
    ty_output_write(output, stored, size);
}

/* A voxel is active if it differs from the background. */
void write_grid(const ty_grid* grid, const char* name, bool zip, ty_output* output) {
    const ty_grid_info info = ty_grid_get_info(grid);
    nanovdb::GridBuilder<float> builder(info.background);
    builder(
        [&](const nanovdb::Coord& at) { return ty_grid_voxel(grid, at[0], at[1], at[2]); },
        nanovdb::CoordBBox(nanovdb::Coord(0), nanovdb::Coord(info.size[0] - 1, info.size[1] - 1, info.size[2] - 1)));
    const auto handle = builder.getHandle<>(make_map(info.index_to_local), name);
    nanovdb::io::Segment segment(zip ? nanovdb::io::Codec::ZIP : nanovdb::io::Codec::NONE);
    segment.add(handle);
    if (!zip) {
        write_file(segment, handle.data(), handle.size(), output);
        return;
    }
    /* The library's own writer leaves the result of compress unread, and so damaged files where memory runs out. */
    uLongf packed_size = compressBound(handle.size());
    const std::unique_ptr<uint8_t[]> packed(new uint8_t[sizeof(uint64_t) + packed_size]);
    if (compress(packed.get() + sizeof(uint64_t), &packed_size, handle.data(), handle.size()) != Z_OK)
        throw std::bad_alloc();
    const uint64_t stored = packed_size;
    std::memcpy(packed.get(), &stored, sizeof stored);
    write_file(segment, packed.get(), sizeof stored + packed_size, output);
}

} /* namespace */

ty_result ty_nanovdb_build(ty_context* context, const ty_grid* grid, const char* name, bool zip, ty_output* output) {
    try {
        write_grid(grid, name, zip, output);
        return TY_OK;
    } catch (const std::bad_alloc&) {
        return ty_fail(context, TY_ERROR_MEMORY, "%s: not enough memory", output->path);
    } catch (const std::exception& error) {
        return ty_fail(context, TY_ERROR_FILE, "%s: %s", output->path, error.what());
    }
}
