/* Our OpenVDB files against OpenVDB itself: it reads what we write and we read what it writes, voxel by voxel, for
 * every codec, floats and halves, scalars and vectors. Built where the library is installed; nothing else links it. */
#include <openvdb/openvdb.h>
#include <openvdb/tools/Prune.h>

#include <tyndall/io.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

constexpr int32_t size[3] = {150, 21, 37}; /* two lower nodes along x, and leaves that are cut */
constexpr double translate[3] = {-10, 20, 0.5}, rotate[3] = {30, -40, 110}, scale[3] = {0.1, 0.25, 3};

void require(bool condition, const std::string& what) {
    if (!condition) throw std::runtime_error(what);
}

void check(ty_context* context, ty_result result) {
    require(result == TY_OK, ty_take_error(context));
}

/* Numbers that halves hold too; a block of one value along x, background elsewhere. */
float value_at(int32_t x, int32_t y, int32_t z, float background) {
    if (x >= 64 && x < 80 && y >= 8 && y < 16) return 0.5F;
    if ((x + 3 * y + 7 * z) % 5 != 0) return background;
    return float(x) * 0.25F - float(y) + float(z) * 0.5F;
}

ty_grid* make_grid(ty_context* context, ty_grid_type type, float background) {
    std::vector<float> floats;
    std::vector<openvdb::math::half> halves;
    for (int32_t z = 0; z < size[2]; ++z)
        for (int32_t y = 0; y < size[1]; ++y)
            for (int32_t x = 0; x < size[0]; ++x) {
                floats.push_back(value_at(x, y, z, background));
                halves.push_back(openvdb::math::half(floats.back()));
            }
    ty_grid_def def = ty_default_grid_def();
    for (int a = 0; a < 3; ++a) def.size[a] = size[a];
    def.type = type;
    def.values = type == TY_GRID_F16 ? static_cast<const void*>(halves.data()) : floats.data();
    def.placed = true;
    def.background = background;
    def.index_to_local = ty_affine_compose(translate, rotate, scale);
    ty_grid* grid = nullptr;
    check(context, ty_grid_create(context, &def, &grid));
    return grid;
}

void library_reads_ours(ty_context* context, const char* codec, ty_grid_type type, float background) {
    const std::string path = std::string("ours_") + codec + ".vdb";
    ty_grid* grid = make_grid(context, type, background);
    check(context, ty_vdb_write(context, grid, "density", codec, path.c_str()));
    ty_grid_release(grid);
    openvdb::io::File file(path);
    file.open();
    const auto read = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid("density"));
    require(read->background() == background, "OpenVDB reads another background");
    require(read->saveFloatAsHalf() == (type == TY_GRID_F16), "OpenVDB reads another type");
    const openvdb::CoordBBox box = read->evalActiveVoxelBoundingBox();
    require(box.min() == openvdb::Coord(0) && box.max() == openvdb::Coord(size[0] - 1, size[1] - 1, size[2] - 1),
            "OpenVDB finds another box of active voxels");
    require(read->metaValue<openvdb::Int64>("file_voxel_count") == openvdb::Int64(read->activeVoxelCount()),
            "the number of active voxels is not that of the tree");
    require(read->tree().activeTileCount() > 0, "no leaf became a tile");
    int64_t active = 0;
    for (int32_t x = -9; x < size[0] + 9; ++x)
        for (int32_t y = -9; y < size[1] + 9; ++y)
            for (int32_t z = -9; z < size[2] + 9; ++z) {
                const bool inside = x >= 0 && y >= 0 && z >= 0 && x < size[0] && y < size[1] && z < size[2];
                const float expected = inside ? value_at(x, y, z, background) : background;
                require(read->tree().getValue(openvdb::Coord(x, y, z)) == expected, "OpenVDB reads another voxel");
                active += expected != background;
            }
    require(int64_t(read->activeVoxelCount()) == active, "OpenVDB counts other active voxels");
    const ty_affine map = ty_affine_compose(translate, rotate, scale);
    const double index[3] = {3, 5, 7};
    double place[3];
    ty_affine_point(&map, index, place);
    const openvdb::Vec3d found = read->indexToWorld(openvdb::Vec3d(index[0], index[1], index[2]));
    for (int a = 0; a < 3; ++a) require(std::abs(found[a] - place[a]) < 1e-9, "OpenVDB reads another transform");
    file.close();
    std::remove(path.c_str());
}

void ours_reads_library(ty_context* context, uint32_t codec, bool half, float background) {
    const char* path = "library.vdb";
    const auto grid = openvdb::FloatGrid::create(background);
    grid->setName("density");
    grid->setSaveFloatAsHalf(half);
    auto accessor = grid->getAccessor();
    for (int32_t x = 0; x < size[0]; ++x)
        for (int32_t y = 0; y < size[1]; ++y)
            for (int32_t z = 0; z < size[2]; ++z) {
                const float value = value_at(x, y, z, background);
                if (value != background) accessor.setValueOn(openvdb::Coord(x, y, z), value);
            }
    openvdb::tools::prune(grid->tree());
    openvdb::io::File file(path);
    file.setCompression(openvdb::io::COMPRESS_ACTIVE_MASK | codec);
    file.write(openvdb::GridPtrVec{grid});
    file.close();
    ty_grid* read = nullptr;
    check(context, ty_vdb_read(context, path, "density", &read));
    const ty_grid_info info = ty_grid_get_info(read);
    require(info.size[0] == size[0] && info.size[1] == size[1] && info.size[2] == size[2], "another size is read");
    for (int32_t x = 0; x < size[0]; ++x)
        for (int32_t y = 0; y < size[1]; ++y)
            for (int32_t z = 0; z < size[2]; ++z)
                require(ty_grid_voxel(read, x, y, z) == value_at(x, y, z, background), "another voxel is read");
    ty_grid_release(read);
    std::remove(path);
}

/* A vector of three grids, the second of which is background elsewhere, and a scalar behind it in the same file. */
void library_reads_vectors(ty_context* context, const char* codec, ty_grid_type type, float background) {
    const std::string path = std::string("vectors_") + codec + ".vdb";
    ty_grid* first = make_grid(context, type, background);
    ty_grid* second = make_grid(context, type, background == 0 ? 0.5F : 0.0F);
    const ty_volume_field fields[2] = {{"fluence", 3, {first, second, first}},
                                       {"density", 1, {second, nullptr, nullptr}}};
    check(context, ty_volume_write(context, fields, 2, codec, path.c_str()));
    const float other = ty_grid_get_info(second).background;
    openvdb::io::File file(path);
    file.open();
    const auto vectors = openvdb::gridPtrCast<openvdb::Vec3SGrid>(file.readGrid("fluence"));
    const auto scalars = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid("density"));
    file.close();
    require(vectors->saveFloatAsHalf() == (type == TY_GRID_F16), "OpenVDB reads another type of vectors");
    require(vectors->background() == openvdb::Vec3s(background, other, background), "another background of vectors");
    require(vectors->tree().activeTileCount() > 0, "no leaf of vectors became a tile");
    int64_t active = 0;
    for (int32_t x = -9; x < size[0] + 9; ++x)
        for (int32_t y = -9; y < size[1] + 9; ++y)
            for (int32_t z = -9; z < size[2] + 9; ++z) {
                const bool inside = x >= 0 && y >= 0 && z >= 0 && x < size[0] && y < size[1] && z < size[2];
                const float a = inside ? value_at(x, y, z, background) : background;
                const float b = inside ? value_at(x, y, z, other) : other;
                require(vectors->tree().getValue(openvdb::Coord(x, y, z)) == openvdb::Vec3s(a, b, a),
                        "OpenVDB reads another vector");
                require(scalars->tree().getValue(openvdb::Coord(x, y, z)) == b, "OpenVDB reads another second grid");
                active += a != background || b != other;
            }
    require(int64_t(vectors->activeVoxelCount()) == active, "OpenVDB counts other active vectors");
    ty_grid_release(first);
    ty_grid_release(second);
    std::remove(path.c_str());
}

void check_all(ty_context* context) {
    for (const float background : {0.0F, -1.25F}) {
        for (const char* codec : {"none", "zip", "blosc"})
            for (const ty_grid_type type : {TY_GRID_F32, TY_GRID_F16}) {
                library_reads_ours(context, codec, type, background);
                library_reads_vectors(context, codec, type, background);
            }
        for (const uint32_t codec :
             {openvdb::io::COMPRESS_NONE, openvdb::io::COMPRESS_ZIP, openvdb::io::COMPRESS_BLOSC})
            for (const bool half : {false, true}) ours_reads_library(context, codec, half, background);
    }
}

} /* namespace */

int main() {
    ty_context* context = nullptr;
    const ty_context_def def = ty_default_context_def();
    if (ty_context_create(&def, &context) != TY_OK) return EXIT_FAILURE;
    int status = EXIT_SUCCESS;
    try {
        openvdb::initialize();
        check_all(context);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        status = EXIT_FAILURE;
    }
    ty_context_destroy(context);
    return status;
}
