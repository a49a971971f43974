/* The only file that sees OpenVDB: trees to dense arrays and back. Exceptions end here. */
#include "io/vdb.h"

extern "C" {
#include "base/context.h"
}

/* OpenVDB's templates keep static data that this library must share with libopenvdb: never hidden. */
#pragma GCC visibility push(default)
#include <openvdb/openvdb.h>
#include <openvdb/tools/Prune.h>
#pragma GCC visibility pop

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <new>
#include <sstream>
#include <vector>

namespace {

constexpr int64_t leaf_side = 8;
constexpr int64_t side_max = 16384;
constexpr int64_t voxels_max = 4000000000;

/* Runs body and turns whatever it throws into a message about path. */
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

/* A tree from the file. Reading stops with an exception at the first byte that cannot be read. */
template <typename Tree>
void read_tree(const ty_vdb_file* file, const ty_vdb_grid* grid, bool values, Tree& tree) {
    std::ifstream stream(file->path, std::ios::binary);
    stream.exceptions(std::ios::failbit | std::ios::badbit);
    stream.seekg(static_cast<std::streamoff>(grid->tree));
    openvdb::io::setVersion(stream, openvdb::VersionId(file->library[0], file->library[1]), file->version);
    openvdb::io::setDataCompression(stream, grid->compression);
    openvdb::io::setHalfFloat(stream, grid->half);
    tree.readTopology(stream, grid->half);
    if (values) tree.readBuffers(stream, grid->half);
}

/* How many voxels lie in the box of a dense array: positive, or 0 with a message. */
ty_result check_box(const ty_vdb_file* file, const ty_vdb_grid* grid, const openvdb::CoordBBox& box, size_t* voxels) {
    double product = 1;
    int64_t side[3];
    for (int a = 0; a < 3; ++a) {
        side[a] = int64_t(box.max()[a]) - box.min()[a] + 1;
        product *= double(side[a]);
    }
    if (product > double(voxels_max) || side[0] > side_max || side[1] > side_max || side[2] > side_max)
        return ty_fail(file->context, TY_ERROR_INPUT,
                       "%s: grid \"%s\" spans %lld x %lld x %lld voxels; dense grids have up to %lld a side and %lld "
                       "in all",
                       file->path, grid->name, (long long)side[0], (long long)side[1], (long long)side[2],
                       (long long)side_max, (long long)voxels_max);
    *voxels = size_t(product);
    return TY_OK;
}

void store(float* to, double value) {
    *to = static_cast<float>(value);
}

void store(uint16_t* to, double value) {
    *to = openvdb::math::half(static_cast<float>(value)).bits();
}

/* Work for ty_parallel_for: one row of leaf-sized cells along x. A cell is either a leaf or of one value. */
template <typename Tree, typename Out>
struct dense_fill {
    const Tree* tree;
    openvdb::CoordBBox box;
    int64_t size[3];
    int64_t first[3], cells[3]; /* in units of leaves */
    Out* values;

    dense_fill(const Tree& source, const openvdb::CoordBBox& bounds, void* target)
        : tree(&source), box(bounds), values(static_cast<Out*>(target)) {
        for (int a = 0; a < 3; ++a) {
            size[a] = int64_t(box.max()[a]) - box.min()[a] + 1;
            first[a] = box.min()[a] >> 3;
            cells[a] = (box.max()[a] >> 3) - first[a] + 1;
        }
    }

    void row(int64_t item) const {
        openvdb::tree::ValueAccessor<const Tree, false> accessor(*tree);
        const int64_t cell_y = first[1] + item % cells[1], cell_z = first[2] + item / cells[1];
        for (int64_t cell_x = first[0]; cell_x < first[0] + cells[0]; ++cell_x) {
            const openvdb::Coord origin(int32_t(cell_x * leaf_side), int32_t(cell_y * leaf_side),
                                        int32_t(cell_z * leaf_side));
            const auto* leaf = accessor.probeConstLeaf(origin);
            cell(origin, leaf == nullptr ? nullptr : leaf->buffer().data(), double(accessor.getValue(origin)));
        }
    }

    template <typename Value>
    void cell(const openvdb::Coord& origin, const Value* leaf, double constant) const {
        int64_t low[3], high[3];
        for (int a = 0; a < 3; ++a) {
            low[a] = std::max<int64_t>(origin[a], box.min()[a]) - origin[a];
            high[a] = std::min<int64_t>(origin[a] + leaf_side - 1, box.max()[a]) - origin[a];
        }
        Out fill;
        store(&fill, constant);
        for (int64_t z = low[2]; z <= high[2]; ++z)
            for (int64_t y = low[1]; y <= high[1]; ++y) {
                const int64_t dense_y = origin[1] + y - box.min()[1], dense_z = origin[2] + z - box.min()[2];
                Out* to = values + size[0] * (dense_y + size[1] * dense_z) + (origin[0] + low[0] - box.min()[0]);
                const int64_t count = high[0] - low[0] + 1;
                if (leaf == nullptr) {
                    for (int64_t x = 0; x < count; ++x) to[x] = fill;
                } else {
                    const Value* from = leaf + 64 * low[0] + 8 * y + z;
                    for (int64_t x = 0; x < count; ++x) store(to + x, double(from[64 * x]));
                }
            }
    }

    static void run(void* user, int64_t item, int32_t) {
        static_cast<const dense_fill*>(user)->row(item);
    }

    void fill(ty_context* context) {
        ty_parallel_for(context, cells[1] * cells[2], run, this);
    }
};

template <typename Tree>
ty_result read_dense(const ty_vdb_file* file, const ty_vdb_grid* grid, ty_vdb_dense* dense) {
    Tree tree;
    read_tree(file, grid, true, tree);
    openvdb::CoordBBox box;
    if (!tree.evalActiveVoxelBoundingBox(box)) box = openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(0));
    size_t voxels = 0;
    const ty_result checked = check_box(file, grid, box, &voxels);
    if (checked != TY_OK) return checked;
    const float background = static_cast<float>(tree.background());
    if (!std::isfinite(background))
        return ty_fail(file->context, TY_ERROR_INPUT, "%s: the background of grid \"%s\" is not finite", file->path,
                       grid->name);
    const bool half = grid->half && std::is_same<typename Tree::ValueType, float>::value;
    void* values = ty_alloc_array(file->context, voxels, half ? sizeof(uint16_t) : sizeof(float), false);
    if (values == nullptr) return TY_ERROR_MEMORY;
    if (half)
        dense_fill<Tree, uint16_t>(tree, box, values).fill(file->context);
    else
        dense_fill<Tree, float>(tree, box, values).fill(file->context);
    for (int a = 0; a < 3; ++a) {
        dense->lower[a] = box.min()[a];
        dense->size[a] = box.max()[a] - box.min()[a] + 1;
    }
    dense->type = half ? TY_GRID_F16 : TY_GRID_F32;
    dense->background = background;
    dense->values = values;
    return TY_OK;
}

template <typename Tree>
ty_result measure(const ty_vdb_file* file, ty_vdb_grid* grid) {
    Tree tree;
    read_tree(file, grid, false, tree);
    openvdb::CoordBBox box;
    tree.evalActiveVoxelBoundingBox(box);
    grid->active_voxels = int64_t(tree.activeVoxelCount());
    for (int a = 0; a < 3; ++a) {
        grid->lower[a] = box.min()[a];
        grid->upper[a] = box.max()[a];
    }
    return TY_OK;
}

bool is_float(const ty_vdb_grid* grid) {
    return std::strcmp(grid->type, "Tree_float_5_4_3") == 0;
}

/* An archive that writes to a stream of ours, so that failures are noticed. */
struct stream_archive : openvdb::io::Archive {
    void write_grid(std::ostream& stream, const openvdb::GridBase::Ptr& grid) const {
        openvdb::io::Archive::write(stream, openvdb::GridPtrVec{grid}, /*seekable=*/true);
    }
};

/* A voxel is active where it differs from the background. */
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

} // namespace

ty_result ty_openvdb_read(const ty_vdb_file* file, const ty_vdb_grid* grid, ty_vdb_dense* dense) {
    return guarded(file->context, file->path, TY_ERROR_INPUT, [&] {
        openvdb::initialize();
        return is_float(grid) ? read_dense<openvdb::FloatTree>(file, grid, dense)
                              : read_dense<openvdb::DoubleTree>(file, grid, dense);
    });
}

ty_result ty_openvdb_measure(const ty_vdb_file* file, ty_vdb_grid* grid) {
    return guarded(file->context, file->path, TY_ERROR_INPUT, [&] {
        openvdb::initialize();
        return is_float(grid) ? measure<openvdb::FloatTree>(file, grid) : measure<openvdb::DoubleTree>(file, grid);
    });
}

bool ty_openvdb_decodes(bool blosc, const void* block, size_t size, size_t raw) {
    try {
        std::istringstream stream(std::string(static_cast<const char*>(block), size));
        std::vector<char> unpacked(raw);
        if (blosc)
            openvdb::io::bloscFromStream(stream, unpacked.data(), raw);
        else
            openvdb::io::unzipFromStream(stream, unpacked.data(), raw);
        return true;
    } catch (...) {
        return false;
    }
}

ty_result ty_openvdb_write(ty_context* context, const ty_grid* grid, const char* name, const char* codec,
                           const char* path, const char* temporary) {
    return guarded(context, path, TY_ERROR_FILE, [&] {
        openvdb::initialize();
        const bool blosc = std::strcmp(codec, "blosc") == 0, zip = std::strcmp(codec, "zip") == 0;
        if (blosc && !openvdb::io::Archive::hasBloscCompression())
            return ty_fail(context, TY_ERROR_UNSUPPORTED, "%s: OpenVDB was built without blosc", path);
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
        std::ofstream stream(temporary, std::ios::binary | std::ios::trunc);
        stream.exceptions(std::ios::failbit | std::ios::badbit);
        archive.write_grid(stream, made);
        stream.close();
        return TY_OK;
    });
}
