/* The only file that includes OpenVDB, for blosc decompression and writing. No exception leaves it. */
#include "io/volumes/vdb.h"

#include "io/output_buffer.hpp"

extern "C" {
#include "base/context.h"
}

/* OpenVDB's templates have static data that must be shared with libopenvdb, so they keep default visibility. */
#pragma GCC visibility push(default)
#include <openvdb/openvdb.h>
#include <openvdb/tools/Prune.h>
#pragma GCC visibility pop

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>
#include <sstream>
#include <vector>

namespace {

constexpr int64_t leaf_side = 8;

/* Runs body and converts any exception to a message about path. */
template <typename Body>
ty_result guarded(ty_context* context, const char* path, ty_result failure, Body body) {
    try {
        return body();
    } catch (const std::bad_alloc&) {
        return ty_fail(context, TY_ERROR_MEMORY, "%s: not enough memory", path);
    } catch (const std::exception& error) {
        return ty_fail(context, failure, "%s: %s", path, error.what());
    } catch (...) {
        return ty_fail(context, TY_ERROR_INTERNAL, "%s: OpenVDB failed", path);
    }
}

/* A stream over memory without a copy. */
struct memory_buffer : std::streambuf {
    memory_buffer(const void* bytes, size_t size) {
        char* begin = const_cast<char*>(static_cast<const char*>(bytes));
        setg(begin, begin, begin + size);
    }
};

/* An archive with a stream of ours, so that write errors are detected. */
struct stream_archive : openvdb::io::Archive {
    void write_grid(std::ostream& stream, const openvdb::GridBase::Ptr& grid) const {
        openvdb::io::Archive::write(stream, openvdb::GridPtrVec{grid}, /* seekable= */ true);
    }
};

/* A voxel is active if it differs from the background. */
void fill_tree(const ty_grid* grid, const ty_grid_info& info, openvdb::FloatTree& tree) {
    openvdb::tree::ValueAccessor<openvdb::FloatTree> accessor(tree);
    for (int32_t z = 0; z < info.size[2]; ++z)
        for (int32_t y = 0; y < info.size[1]; ++y)
            for (int32_t x0 = 0; x0 < info.size[0]; x0 += int32_t(leaf_side)) {
                openvdb::FloatTree::LeafNodeType* leaf = nullptr;
                const int32_t x1 = std::min(x0 + int32_t(leaf_side), info.size[0]);
                for (int32_t x = x0; x < x1; ++x) {
                    const float value = ty_grid_voxel(grid, x, y, z);
                    if (value == info.background) continue;
                    if (leaf == nullptr) leaf = accessor.touchLeaf(openvdb::Coord(x0, y, z));
                    leaf->setValueOn(openvdb::Coord(x, y, z), value);
                }
            }
    openvdb::tools::prune(tree);
}

openvdb::math::Transform::Ptr make_transform(const ty_affine& map) {
    openvdb::Mat4d matrix = openvdb::Mat4d::identity();
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 4; ++c) matrix(c, r) = map.m[4 * r + c]; /* OpenVDB multiplies row vectors */
    return openvdb::math::Transform::createLinearTransform(matrix);
}

} /* namespace */

bool ty_openvdb_unpack_blosc(const void* block, size_t size, void* to, size_t raw) {
    try {
        memory_buffer buffer(block, size);
        std::istream stream(&buffer);
        openvdb::io::bloscFromStream(stream, static_cast<char*>(to), raw);
        return true;
    } catch (...) {
        return false;
    }
}

ty_result ty_openvdb_write(ty_context* context, const ty_grid* grid, const char* name, const char* codec,
                           ty_output* output) {
    return guarded(context, output->path, TY_ERROR_FILE, [&] {
        openvdb::initialize();
        const bool blosc = std::strcmp(codec, "blosc") == 0, zip = std::strcmp(codec, "zip") == 0;
        if (blosc && !openvdb::io::Archive::hasBloscCompression())
            return ty_fail(context, TY_ERROR_UNSUPPORTED, "%s: OpenVDB was built without blosc", output->path);
        const ty_grid_info info = ty_grid_get_info(grid);
        const openvdb::FloatGrid::Ptr made = openvdb::FloatGrid::create(info.background);
        made->setName(name);
        made->setSaveFloatAsHalf(info.type == TY_GRID_F16);
        made->setTransform(make_transform(info.index_to_local));
        fill_tree(grid, info, made->tree());

        stream_archive archive;
        archive.setCompression(openvdb::io::COMPRESS_ACTIVE_MASK | (blosc ? openvdb::io::COMPRESS_BLOSC
                                                                    : zip ? openvdb::io::COMPRESS_ZIP
                                                                          : openvdb::io::COMPRESS_NONE));
        ty_output_buffer buffer(output);
        std::ostream stream(&buffer);
        archive.write_grid(stream, made);
        return TY_OK;
    });
}
