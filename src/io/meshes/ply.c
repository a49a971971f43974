/* PLY files: text or binary of either byte order. Vertices and faces are read, other elements skipped. Polygons are
 * split into triangle fans about their first corner, which is right for convex ones. */
#include "io/meshes/ply.h"

#include "base/context.h"
#include "image/image.h"

#include <math.h>
#include <string.h>

typedef struct ply_triangle {
    uint32_t corners[3];
} ply_triangle;

typedef struct builder {
    ty_ply* ply;
    ty_model_mesh mesh;
    ply_triangle* triangles;
    size_t triangle_count, triangle_capacity;
    float coded[256]; /* linear value of an sRGB byte */
} builder;

static ty_result fail_short(const ty_ply* ply) {
    return ty_fail(ply->context, TY_ERROR_INPUT, "%s: the data are damaged or cut short", ply->path);
}

/* ---- numbers ---- */

static double load_number(const uint8_t bytes[8], ty_ply_type type) {
    uint16_t u16;
    uint32_t u32;
    float f32;
    double f64;
    memcpy(&u16, bytes, sizeof u16);
    memcpy(&u32, bytes, sizeof u32);
    memcpy(&f32, bytes, sizeof f32);
    memcpy(&f64, bytes, sizeof f64);
    switch (type) {
    case TY_PLY_I8: return (int8_t)bytes[0];
    case TY_PLY_U8: return bytes[0];
    case TY_PLY_I16: return (int16_t)u16;
    case TY_PLY_U16: return u16;
    case TY_PLY_I32: return (int32_t)u32;
    case TY_PLY_U32: return u32;
    case TY_PLY_F32: return f32;
    default: return f64;
    }
}

/* Reads the next number; false at the end of the data. */
static bool read_number(ty_ply* ply, ty_ply_type type, double* out) {
    if (ply->format == TY_PLY_ASCII) return ty_next_number(&ply->data, out);
    const size_t size = ty_ply_type_size(type);
    if ((size_t)(ply->data.end - ply->data.at) < size) return false;
    uint8_t bytes[8] = {0};
    for (size_t i = 0; i < size; ++i) bytes[ply->format == TY_PLY_BIG ? size - 1 - i : i] = (uint8_t)ply->data.at[i];
    ply->data.at += size;
    *out = load_number(bytes, type);
    return true;
}

/* Reads the count of a list; every item takes at least one byte. */
static bool read_count(ty_ply* ply, ty_ply_type type, size_t* count) {
    double number = 0;
    if (!read_number(ply, type, &number)) return false;
    if (!(number >= 0) || number != floor(number) || number > (double)(ply->data.end - ply->data.at)) return false;
    *count = (size_t)number;
    return true;
}

static bool skip_property(ty_ply* ply, const ty_ply_property* property) {
    size_t count = 1;
    double number;
    if (property->list && !read_count(ply, property->count_type, &count)) return false;
    for (size_t i = 0; i < count; ++i)
        if (!read_number(ply, property->type, &number)) return false;
    return true;
}

/* Minimum bytes of one row of an element. */
static size_t row_size_min(const ty_ply* ply, const ty_ply_element* element) {
    size_t size = 0;
    for (size_t i = 0; i < element->property_count; ++i) {
        const ty_ply_property* property = &ply->properties[element->first + i];
        size +=
            ply->format == TY_PLY_ASCII ? 2 : ty_ply_type_size(property->list ? property->count_type : property->type);
    }
    return size;
}

/* The last number of a text may lack a trailing blank. */
static bool rows_fit(const ty_ply* ply, const ty_ply_element* element) {
    const size_t left = (size_t)(ply->data.end - ply->data.at) + (ply->format == TY_PLY_ASCII);
    size_t needed = 0;
    return !__builtin_mul_overflow(element->count, row_size_min(ply, element), &needed) && needed <= left;
}

/* ---- vertices ---- */

/* Integers are sRGB, 0..max; floats are linear. */
static float to_linear(const builder* b, double value, ty_ply_type type, bool alpha) {
    if (type >= TY_PLY_F32) return (float)value;
    const bool wide = type == TY_PLY_I16 || type == TY_PLY_U16;
    const double unit = fmin(fmax(value / (wide ? 65535 : 255), 0), 1);
    return alpha ? (float)unit : b->coded[(int)(255 * unit + 0.5)];
}

static ty_result store_vertex(builder* b, size_t i, const double row[TY_PLY_ROW]) {
    ty_model_mesh* mesh = &b->mesh;
    for (size_t a = 0; a < 3; ++a) {
        if (!(fabs(row[TY_PLY_X + a]) <= 3e38))
            return ty_fail(b->ply->context, TY_ERROR_INPUT, "%s: vertex %zu is not finite", b->ply->path, i);
        mesh->positions[3 * i + a] = (float)row[TY_PLY_X + a];
        if (mesh->normals != NULL) mesh->normals[3 * i + a] = (float)row[TY_PLY_NORMAL + a];
    }
    if (mesh->uv[0] != NULL) {
        mesh->uv[0][2 * i] = (float)row[TY_PLY_UV];
        mesh->uv[0][2 * i + 1] = (float)(1 - row[TY_PLY_UV + 1]); /* v points up in the file */
    }
    for (size_t c = 0; c < 4 && mesh->colors != NULL; ++c) mesh->colors[4 * i + c] = (float)row[TY_PLY_COLOR + c];
    return TY_OK;
}

static ty_result parse_vertices(builder* b, const ty_ply_element* element) {
    ty_ply* ply = b->ply;
    double row[TY_PLY_ROW] = {[TY_PLY_ALPHA] = 1};
    for (size_t i = 0; i < element->count; ++i) {
        for (size_t k = 0; k < element->property_count; ++k) {
            const ty_ply_property* property = &ply->properties[element->first + k];
            const bool used = property->role < TY_PLY_ROW;
            if (used ? !read_number(ply, property->type, &row[property->role]) : !skip_property(ply, property))
                return fail_short(ply);
            if (used && property->role >= TY_PLY_COLOR)
                row[property->role] = to_linear(b, row[property->role], property->type, property->role == TY_PLY_ALPHA);
        }
        const ty_result result = store_vertex(b, i, row);
        if (result != TY_OK) return result;
    }
    return TY_OK;
}

/* ---- faces ---- */

/* Reads a corner's vertex index; indices out of range are refused. */
static ty_result read_corner(builder* b, ty_ply_type type, uint32_t* out) {
    double number = 0;
    if (!read_number(b->ply, type, &number)) return fail_short(b->ply);
    if (!(number >= 0 && number < (double)b->mesh.vertex_count) || number != floor(number))
        return ty_fail(b->ply->context, TY_ERROR_INPUT, "%s: a face names vertex %.0f of %zu", b->ply->path, number,
                       b->mesh.vertex_count);
    *out = (uint32_t)number;
    return TY_OK;
}

static ty_result read_face(builder* b, const ty_ply_property* property) {
    ply_triangle triangle = {{0, 0, 0}};
    size_t count = 0;
    if (!read_count(b->ply, property->count_type, &count)) return fail_short(b->ply);
    for (size_t i = 0; i < count; ++i) {
        uint32_t* corner = &triangle.corners[i < 2 ? i : 2];
        const ty_result result = read_corner(b, property->type, corner);
        if (result != TY_OK) return result;
        if (i < 2) continue;
        if (!ty_grow_array(b->ply->context, (void**)&b->triangles, &b->triangle_capacity, b->triangle_count,
                           sizeof *b->triangles))
            return TY_ERROR_MEMORY;
        b->triangles[b->triangle_count++] = triangle;
        triangle.corners[1] = *corner;
    }
    return TY_OK;
}

static ty_result read_faces(builder* b, const ty_ply_element* element) {
    ty_ply* ply = b->ply;
    for (size_t i = 0; i < element->count; ++i)
        for (size_t k = 0; k < element->property_count; ++k) {
            const ty_ply_property* property = &ply->properties[element->first + k];
            ty_result result = TY_OK;
            if (property->role == TY_PLY_CORNERS)
                result = read_face(b, property);
            else if (!skip_property(ply, property))
                result = fail_short(ply);
            if (result != TY_OK) return result;
        }
    return TY_OK;
}

static ty_result skip_rows(ty_ply* ply, const ty_ply_element* element) {
    for (size_t i = 0; i < element->count && element->property_count > 0; ++i)
        for (size_t k = 0; k < element->property_count; ++k)
            if (!skip_property(ply, &ply->properties[element->first + k])) return fail_short(ply);
    return TY_OK;
}

/* ---- whole file ---- */

static bool has_all(const ty_ply* ply, const ty_ply_element* element, int32_t low, int32_t high) {
    uint32_t found = 0;
    for (size_t i = 0; i < element->property_count; ++i) {
        const int32_t role = ply->properties[element->first + i].role;
        if (role >= low && role <= high) found |= 1u << (role - low);
    }
    return found == (1u << (high - low + 1)) - 1;
}

static ty_result read_vertices(builder* b, unsigned want) {
    const ty_ply* ply = b->ply;
    const ty_ply_element* element = ply->elements;
    while (element->kind != TY_PLY_VERTEX) ++element; /* the header check guarantees a vertex element */
    if (!rows_fit(ply, element))
        return ty_fail(ply->context, TY_ERROR_INPUT, "%s: cut short: no room for %zu vertices", ply->path,
                       element->count);
    const bool shading = (want & TY_MODEL_SHADING) != 0;
    b->mesh.vertex_count = element->count;
    return ty_model_alloc_mesh(ply->context, &b->mesh, shading && has_all(ply, element, TY_PLY_NORMAL, TY_PLY_UV - 1),
                               shading && has_all(ply, element, TY_PLY_UV, TY_PLY_COLOR - 1), false,
                               shading && has_all(ply, element, TY_PLY_COLOR, TY_PLY_ALPHA - 1));
}

static ty_result read_elements(builder* b) {
    ty_ply* ply = b->ply;
    ty_result result = TY_OK;
    for (size_t i = 0; i < ply->element_count && result == TY_OK; ++i) {
        const ty_ply_element* element = &ply->elements[i];
        if (!rows_fit(ply, element)) return fail_short(ply);
        result = element->kind == TY_PLY_VERTEX ? parse_vertices(b, element)
                 : element->kind == TY_PLY_FACE ? read_faces(b, element)
                                                : skip_rows(ply, element);
    }
    if (result == TY_OK && b->triangle_count == 0)
        return ty_fail(ply->context, TY_ERROR_INPUT, "%s: no face has three corners", ply->path);
    return result;
}

/* Moves the triangles to the mesh and the mesh to the model. */
static ty_result finish(builder* b, unsigned want, ty_model* model) {
    ty_context* context = b->ply->context;
    ty_model_mesh* mesh = &b->mesh;
    ty_free_array(context, mesh->indices, mesh->triangle_count, 3 * sizeof(uint32_t));
    mesh->triangle_count = 0;
    mesh->indices = ty_alloc_array(context, b->triangle_count, 3 * sizeof(uint32_t), false);
    if (mesh->indices == NULL) return TY_ERROR_MEMORY;
    mesh->triangle_count = b->triangle_count;
    memcpy(mesh->indices, b->triangles, b->triangle_count * sizeof *b->triangles);
    mesh->material = (want & TY_MODEL_MATERIALS) != 0 ? 0 : -1;
    const bool colored = mesh->colors != NULL;
    ty_model_tidy_shading(mesh);
    ty_result result = ty_model_add_mesh(model, mesh);
    *mesh = (ty_model_mesh){0}; /* the arrays now belong to the model, or are freed */
    const ty_affine identity = ty_affine_identity();
    if (result == TY_OK) result = ty_model_add_instance(model, 0, &identity, -1, NULL);
    if (result != TY_OK || (want & TY_MODEL_MATERIALS) == 0) return result;
    /* Vertex colors replace those of the material. */
    ty_model_material plain = ty_model_plain_material(colored ? 1 : ty_default_material_def().albedo[0]);
    plain.plain = true;
    plain.name = ty_copy_text(context, "");
    return ty_model_add_material(model, &plain);
}

static void close_header(ty_ply* ply) {
    ty_free_array(ply->context, ply->elements, ply->element_capacity, sizeof *ply->elements);
    ty_free_array(ply->context, ply->properties, ply->property_capacity, sizeof *ply->properties);
}

ty_result ty_read_ply(ty_context* context, const char* path, const uint8_t* bytes, size_t size, unsigned want,
                      ty_model* model) {
    *model = (ty_model){.context = context};
    ty_ply ply = {.context = context, .path = path, .data = {(const char*)bytes, (const char*)bytes + size}};
    builder b = {.ply = &ply};
    for (int i = 0; i < 256; ++i) b.coded[i] = ty_linear_from_srgb((float)i / 255);
    ty_result result = ty_ply_read_header(&ply);
    if (result == TY_OK) result = read_vertices(&b, want);
    if (result == TY_OK) result = read_elements(&b);
    if (result == TY_OK) result = finish(&b, want, model);
    ty_model_free_mesh(context, &b.mesh);
    ty_free_array(context, b.triangles, b.triangle_capacity, sizeof *b.triangles);
    close_header(&ply);
    return result;
}

/* Bytes of a property in a binary file at most; lists of 2^31 and more corners are not made. */
static uint64_t longest_property(const ty_ply_property* property) {
    const uint64_t size = ty_ply_type_size(property->type);
    const size_t count_size = ty_ply_type_size(property->count_type);
    if (!property->list) return size;
    return count_size + size * (count_size == 1 ? UINT8_MAX : count_size == 2 ? UINT16_MAX : INT32_MAX);
}

static uint64_t longest_rows(const ty_ply* ply) {
    uint64_t longest = 0;
    for (size_t i = 0; i < ply->element_count; ++i) {
        const ty_ply_element* element = &ply->elements[i];
        uint64_t row = 0, rows;
        for (size_t k = 0; k < element->property_count; ++k)
            row += longest_property(&ply->properties[element->first + k]);
        if (__builtin_mul_overflow(row, (uint64_t)element->count, &rows) ||
            __builtin_add_overflow(longest, rows, &longest))
            return UINT64_MAX / 2;
    }
    return longest;
}

ty_result ty_inspect_ply(ty_context* context, const char* path, uint8_t* head, size_t size, ty_file_form* form) {
    ty_ply ply = {.context = context, .path = path, .data = {(const char*)head, (const char*)head + size}};
    const ty_result result = ty_ply_read_header(&ply);
    form->text = ply.format == TY_PLY_ASCII;
    if (result == TY_OK && !form->text) form->longest = size + TY_FILE_SLACK + longest_rows(&ply);
    close_header(&ply);
    return result;
}
