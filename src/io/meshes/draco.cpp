/* The only file that includes Draco's C++ library. No exception leaves it. */
#include "io/meshes/draco.h"

extern "C" {
#include "base/context.h"
}

#if TYNDALL_DRACO

#include <draco/compression/decode.h>

#include <memory>
#include <new>

struct ty_draco {
    std::unique_ptr<draco::Mesh> mesh;
};

ty_result ty_draco_decode(ty_context* context, const char* place, const uint8_t* bytes, size_t size, ty_draco** out) {
    try {
        draco::DecoderBuffer buffer;
        buffer.Init(reinterpret_cast<const char*>(bytes), size);
        draco::Decoder decoder;
        auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
        if (!decoded.ok())
            return ty_fail(context, TY_ERROR_INPUT, "%s: cannot decode this Draco mesh: %s", place,
                           decoded.status().error_msg());
        *out = new ty_draco{std::move(decoded).value()};
        return TY_OK;
    } catch (const std::bad_alloc&) {
        return ty_fail(context, TY_ERROR_MEMORY, "%s: cannot decode this Draco mesh: not enough memory", place);
    } catch (const std::exception& error) {
        return ty_fail(context, TY_ERROR_INPUT, "%s: cannot decode this Draco mesh: %s", place, error.what());
    }
}

void ty_draco_free(ty_draco* draco) {
    delete draco;
}

size_t ty_draco_vertices(const ty_draco* draco) {
    return draco->mesh->num_points();
}

size_t ty_draco_triangles(const ty_draco* draco) {
    return draco->mesh->num_faces();
}

bool ty_draco_read_indices(const ty_draco* draco, uint32_t* out) {
    for (uint32_t i = 0; i < draco->mesh->num_faces(); ++i) {
        const draco::Mesh::Face& face = draco->mesh->face(draco::FaceIndex(i));
        for (size_t k = 0; k < 3; ++k) {
            if (face[k].value() >= draco->mesh->num_points()) return false;
            *out++ = face[k].value();
        }
    }
    return true;
}

bool ty_draco_read_attribute(const ty_draco* draco, uint32_t id, size_t width, float* out, bool* normalized) {
    const draco::PointAttribute* attribute = draco->mesh->GetAttributeByUniqueId(id);
    if (attribute == nullptr || attribute->num_components() != static_cast<int>(width)) return false;
    *normalized = attribute->normalized();
    for (uint32_t i = 0; i < draco->mesh->num_points(); ++i) {
        const draco::AttributeValueIndex value = attribute->mapped_index(draco::PointIndex(i));
        if (value.value() >= attribute->size() ||
            !attribute->ConvertValue<float>(value, static_cast<int8_t>(width), out + i * width))
            return false;
    }
    return true;
}

#else

ty_result ty_draco_decode(ty_context* context, const char* place, const uint8_t*, size_t, ty_draco**) {
    return ty_fail(
        context, TY_ERROR_INPUT,
        "%s: compressed by Draco, which this build was made without; \"gltf-transform copy\" decompresses it", place);
}

void ty_draco_free(ty_draco*) {
}

size_t ty_draco_vertices(const ty_draco*) {
    return 0;
}

size_t ty_draco_triangles(const ty_draco*) {
    return 0;
}

bool ty_draco_read_indices(const ty_draco*, uint32_t*) {
    return false;
}

bool ty_draco_read_attribute(const ty_draco*, uint32_t, size_t, float*, bool*) {
    return false;
}

#endif
