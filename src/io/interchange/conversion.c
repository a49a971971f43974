/* The content of a conversion, until it is written. */
#include "io/interchange/conversion.h"

#include "base/context.h"
#include "io/file.h"
#include "io/json_text.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- notes ---- */

static bool count_known(ty_conversion* conversion, const char* text) {
    for (size_t i = 0; i < conversion->note_count; ++i) {
        if (strcmp(conversion->notes[i].text, text) != 0) continue;
        ++conversion->notes[i].count;
        return true;
    }
    return false;
}

static void keep(ty_conversion* conversion, const char* kind, const char* format, va_list arguments) {
    char text[512];
    const int length = snprintf(text, sizeof text, "%s: ", kind);
    vsnprintf(text + length, sizeof text - (size_t)length, format, arguments);
    for (char* at = text; *at != '\0'; ++at)
        if (*at < ' ' || *at > '~') *at = '?'; /* names from files need not be text */
    if (count_known(conversion, text)) return;
    if (conversion->note_count >= TY_CONVERSION_NOTES_MAX) snprintf(text, sizeof text, "further notes are not listed");
    if (conversion->note_count > TY_CONVERSION_NOTES_MAX && count_known(conversion, text)) return;
    if (!ty_grow_array(conversion->context, (void**)&conversion->notes, &conversion->note_capacity,
                       conversion->note_count, sizeof *conversion->notes))
        return;
    char* copy = ty_copy_text(conversion->context, text);
    if (copy != NULL) conversion->notes[conversion->note_count++] = (ty_conversion_note){copy, 1};
}

void ty_conversion_leave_out(ty_conversion* conversion, const char* format, ...) {
    va_list arguments;
    va_start(arguments, format);
    keep(conversion, "left out", format, arguments);
    va_end(arguments);
}

void ty_conversion_approximate(ty_conversion* conversion, const char* format, ...) {
    va_list arguments;
    va_start(arguments, format);
    keep(conversion, "approximated", format, arguments);
    va_end(arguments);
}

void ty_conversion_print_note(const ty_conversion_note* note, char* line, size_t size) {
    if (note->count > 1)
        snprintf(line, size, "%s (%d times)", note->text, (int)note->count);
    else
        snprintf(line, size, "%s", note->text);
}

/* ---- content ---- */

ty_result ty_conversion_no_memory(ty_conversion* conversion) {
    return ty_fail(conversion->context, TY_ERROR_MEMORY, "%s: not enough memory", conversion->input);
}

ty_result ty_conversion_set(ty_conversion* conversion, json_t* object, const char* key, json_t* value) {
    return json_object_set_new(object, key, value) == 0 ? TY_OK : ty_conversion_no_memory(conversion);
}

/* The index of an equal material; -1 without. */
static int32_t find_material(const ty_conversion* conversion, const ty_conversion_material* material) {
    for (size_t i = 0; i < conversion->material_count; ++i) {
        const ty_conversion_material* other = &conversion->materials[i];
        if (other->hash == material->hash && other->medium == material->medium &&
            other->textured == material->textured &&
            memcmp(other->uv_map, material->uv_map, sizeof other->uv_map) == 0 &&
            json_equal(other->keys, material->keys))
            return (int32_t)i;
    }
    return -1;
}

ty_result ty_conversion_add_material(ty_conversion* conversion, ty_conversion_material* material, int32_t* index) {
    char* text = json_dumps(material->keys, JSON_COMPACT | JSON_SORT_KEYS);
    material->hash = text != NULL ? ty_hash_bytes(TY_HASH_START, text, strlen(text)) : 0;
    free(text);
    *index = find_material(conversion, material);
    if (*index >= 0) {
        json_decref(material->keys);
        return TY_OK;
    }
    if (!ty_grow_array(conversion->context, (void**)&conversion->materials, &conversion->material_capacity,
                       conversion->material_count, sizeof *conversion->materials)) {
        json_decref(material->keys);
        return TY_ERROR_MEMORY;
    }
    *index = (int32_t)conversion->material_count;
    conversion->materials[conversion->material_count++] = *material;
    return TY_OK;
}

ty_result ty_conversion_add_medium(ty_conversion* conversion, ty_conversion_medium* medium, int32_t* index) {
    if (!ty_grow_array(conversion->context, (void**)&conversion->media, &conversion->medium_capacity,
                       conversion->medium_count, sizeof *conversion->media)) {
        ty_free_text(conversion->context, medium->name);
        json_decref(medium->entries);
        return TY_ERROR_MEMORY;
    }
    *index = (int32_t)conversion->medium_count;
    conversion->media[conversion->medium_count++] = *medium;
    return TY_OK;
}

ty_result ty_conversion_add_light(ty_conversion* conversion, json_t* light) {
    if (light == NULL || json_array_append_new(conversion->lights, light) != 0)
        return ty_conversion_no_memory(conversion);
    return TY_OK;
}

ty_result ty_conversion_find_part(ty_conversion* conversion, int32_t material, int32_t medium, const double emission[3],
                                  int32_t* index) {
    /* A medium fills a solid dielectric whose mesh bounds it, and that is one mesh. */
    const bool filled =
        medium >= 0 && material >= 0 && json_object_get(conversion->materials[material].keys, "volume") != NULL;
    for (size_t i = conversion->part_count; i-- > 0 && !filled;) {
        const ty_conversion_part* part = &conversion->parts[i];
        if (part->material != material || part->medium != medium ||
            memcmp(part->emission, emission, sizeof part->emission) != 0)
            continue;
        *index = (int32_t)i;
        return TY_OK;
    }
    if (!ty_grow_array(conversion->context, (void**)&conversion->parts, &conversion->part_capacity,
                       conversion->part_count, sizeof *conversion->parts))
        return TY_ERROR_MEMORY;
    *index = (int32_t)conversion->part_count;
    conversion->parts[conversion->part_count++] =
        (ty_conversion_part){material, medium, {emission[0], emission[1], emission[2]}};
    return TY_OK;
}

ty_result ty_conversion_add_mesh(ty_conversion* conversion, int32_t part, ty_model_mesh* mesh, size_t* index) {
    if (!ty_grow_array(conversion->context, (void**)&conversion->meshes, &conversion->mesh_capacity,
                       conversion->mesh_count, sizeof *conversion->meshes)) {
        ty_model_free_mesh(conversion->context, mesh);
        return TY_ERROR_MEMORY;
    }
    *index = conversion->mesh_count;
    conversion->meshes[conversion->mesh_count++] = (ty_conversion_mesh){*mesh, part};
    return TY_OK;
}

ty_result ty_conversion_add_instance(ty_conversion* conversion, size_t mesh, const ty_affine* transform) {
    enum { INSTANCES_MAX = 1 << 24 };
    if (conversion->instance_count >= INSTANCES_MAX)
        return ty_fail(conversion->context, TY_ERROR_INPUT, "%s: there are more than %d instances of meshes",
                       conversion->input, (int)INSTANCES_MAX);
    if (!ty_grow_array(conversion->context, (void**)&conversion->instances, &conversion->instance_capacity,
                       conversion->instance_count, sizeof *conversion->instances))
        return TY_ERROR_MEMORY;
    conversion->instances[conversion->instance_count++] = (ty_conversion_instance){mesh, *transform};
    conversion->triangles += (int64_t)conversion->meshes[mesh].mesh.triangle_count;
    return TY_OK;
}

ty_result ty_conversion_add_sphere(ty_conversion* conversion, int32_t part, const double center[3], double radius) {
    if (!ty_grow_array(conversion->context, (void**)&conversion->spheres, &conversion->sphere_capacity,
                       conversion->sphere_count, sizeof *conversion->spheres))
        return TY_ERROR_MEMORY;
    conversion->spheres[conversion->sphere_count++] =
        (ty_conversion_sphere){part, {center[0], center[1], center[2]}, radius};
    return TY_OK;
}

/* ---- JSON ---- */

json_t* ty_conversion_colour(const double rgb[3], double low, double high) {
    double values[3];
    for (int c = 0; c < 3; ++c) values[c] = fmin(fmax(isnan(rgb[c]) ? low : rgb[c], low), high);
    if (values[0] == values[1] && values[1] == values[2]) return ty_json_number(values[0]);
    return ty_conversion_vector(values, 3);
}

json_t* ty_conversion_vector(const double* values, int count) {
    json_t* array = json_array();
    for (int i = 0; i < count; ++i) {
        if (json_array_append_new(array, ty_json_number(values[i])) == 0) continue;
        json_decref(array);
        return NULL;
    }
    return array;
}

json_t* ty_conversion_transform(const ty_affine* transform) {
    static const double last[4] = {0, 0, 0, 1};
    double numbers[16];
    memcpy(numbers, transform->m, sizeof transform->m);
    memcpy(numbers + 12, last, sizeof last);
    return ty_conversion_vector(numbers, 16);
}

/* ---- begin and end ---- */

/* Names the folder of files after the scene file: "out/fog.json" has "out/fog_files". */
static ty_result name_files(ty_conversion* conversion) {
    const char* name = strrchr(conversion->output, '/');
    name = name == NULL ? conversion->output : name + 1;
    const char* dot = strrchr(name, '.');
    const int length = (int)(dot == NULL || dot == name ? strlen(name) : (size_t)(dot - name));
    char text[512];
    snprintf(text, sizeof text, "%.*s_files", length, name);
    char* folder = ty_folder_of(conversion->context, conversion->output);
    if (folder == NULL) return TY_ERROR_MEMORY;
    conversion->files_name = ty_copy_text(conversion->context, text);
    conversion->files = ty_join_path(conversion->context, folder, text);
    ty_free_text(conversion->context, folder);
    return conversion->files != NULL && conversion->files_name != NULL ? TY_OK : TY_ERROR_MEMORY;
}

ty_result ty_conversion_open(ty_conversion* conversion, ty_context* context, const char* input, const char* folder,
                             const char* output) {
    *conversion = (ty_conversion){.context = context, .input = input, .folder = folder, .output = output};
    conversion->lights = json_array();
    ty_result result = conversion->lights == NULL ? ty_conversion_no_memory(conversion) : TY_OK;
    if (result == TY_OK && output != NULL) result = name_files(conversion);
    if (result != TY_OK) ty_conversion_close(conversion);
    return result;
}

void ty_conversion_close(ty_conversion* conversion) {
    ty_context* context = conversion->context;
    for (size_t i = 0; i < conversion->material_count; ++i) json_decref(conversion->materials[i].keys);
    for (size_t i = 0; i < conversion->medium_count; ++i) {
        ty_free_text(context, conversion->media[i].name);
        json_decref(conversion->media[i].entries);
    }
    for (size_t i = 0; i < conversion->mesh_count; ++i) ty_model_free_mesh(context, &conversion->meshes[i].mesh);
    for (size_t i = 0; i < conversion->note_count; ++i) ty_free_text(context, conversion->notes[i].text);
    ty_free_array(context, conversion->materials, conversion->material_capacity, sizeof *conversion->materials);
    ty_free_array(context, conversion->media, conversion->medium_capacity, sizeof *conversion->media);
    ty_free_array(context, conversion->parts, conversion->part_capacity, sizeof *conversion->parts);
    ty_free_array(context, conversion->meshes, conversion->mesh_capacity, sizeof *conversion->meshes);
    ty_free_array(context, conversion->instances, conversion->instance_capacity, sizeof *conversion->instances);
    ty_free_array(context, conversion->spheres, conversion->sphere_capacity, sizeof *conversion->spheres);
    ty_free_array(context, conversion->notes, conversion->note_capacity, sizeof *conversion->notes);
    json_decref(conversion->camera);
    json_decref(conversion->lights);
    json_decref(conversion->render);
    ty_free_text(context, conversion->files);
    ty_free_text(context, conversion->files_name);
    *conversion = (ty_conversion){0};
}
