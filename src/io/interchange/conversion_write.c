/* The scene file of a conversion. */
#include "io/interchange/conversion.h"

#include "base/context.h"
#include "io/file.h"
#include "io/json_text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static ty_result no_memory(ty_conversion* conversion) {
    return ty_fail(conversion->context, TY_ERROR_MEMORY, "%s: not enough memory", conversion->input);
}

/* The keys of a surface's material with the part's emission; NULL: out of memory. */
static json_t* make_material(const ty_conversion* conversion, const ty_conversion_part* part) {
    const ty_conversion_material* material = &conversion->materials[part->material];
    json_t* keys = json_deep_copy(material->keys);
    const bool emits = part->emission[0] > 0 || part->emission[1] > 0 || part->emission[2] > 0;
    if (!emits) return keys;
    if (json_object_set_new(keys, "emission", ty_conversion_colour(part->emission, 0, 1e9)) == 0) return keys;
    json_decref(keys);
    return NULL;
}

/* Adds a surface, which is taken over, with the material of a part. */
static ty_result add_surface(ty_conversion* conversion, const ty_conversion_part* part, json_t* surface,
                             json_t* geometry) {
    const bool done = json_object_set_new(surface, "material", make_material(conversion, part)) == 0;
    return json_array_append_new(geometry, surface) == 0 && done ? TY_OK : no_memory(conversion);
}

static bool has_meshes(const ty_conversion* conversion, int32_t part) {
    for (size_t i = 0; i < conversion->instance_count; ++i)
        if (conversion->meshes[conversion->instances[i].mesh].part == part) return true;
    return false;
}

static bool is_surface(const ty_conversion* conversion, const ty_conversion_part* part) {
    return part->material >= 0 && conversion->materials[part->material].keys != NULL;
}

static ty_result add_part(ty_conversion* conversion, int32_t number, char** file, json_t* geometry) {
    const ty_conversion_part* part = &conversion->parts[number];
    const bool surface = is_surface(conversion, part);
    if (!has_meshes(conversion, number) || (!surface && part->medium < 0)) return TY_OK;
    json_t* quad = surface ? ty_conversion_part_quad(conversion, number) : NULL;
    if (quad != NULL) return add_surface(conversion, part, quad, geometry);
    const ty_result result = ty_conversion_write_part(conversion, number, file);
    if (result != TY_OK || !surface || *file == NULL) return result;
    return add_surface(conversion, part, json_pack("{s:s}", "file", *file), geometry);
}

static ty_result add_spheres(ty_conversion* conversion, json_t* geometry) {
    ty_result result = TY_OK;
    for (size_t i = 0; i < conversion->sphere_count && result == TY_OK; ++i) {
        const ty_conversion_sphere* sphere = &conversion->spheres[i];
        const ty_conversion_part* part = &conversion->parts[sphere->part];
        if (!is_surface(conversion, part)) continue;
        result = add_surface(conversion, part,
                             json_pack("{s:{s:o, s:o}}", "sphere", "center", ty_conversion_vector(sphere->center, 3),
                                       "radius", ty_json_number(sphere->radius)),
                             geometry);
    }
    return result;
}

/* The notes, and before them the origin of the file. */
static json_t* make_comment(const ty_conversion* conversion) {
    char line[640];
    const char* name = strrchr(conversion->input, '/');
    snprintf(line, sizeof line, "converted from %s%s", name == NULL ? conversion->input : name + 1,
             conversion->note_count > 0 ? "; left out or approximated:" : "");
    json_t* lines = json_pack("[s]", line);
    for (size_t i = 0; i < conversion->note_count; ++i) {
        ty_conversion_print_note(&conversion->notes[i], line, sizeof line);
        if (json_array_append_new(lines, json_string(line)) != 0) {
            json_decref(lines);
            return NULL;
        }
    }
    return lines;
}

/* Text in which values without objects stand on one line. */
static void print(ty_text* text, const json_t* value, int depth) {
    static const char blanks[] = "                                ";
    const int indent = 2 * depth < (int)sizeof blanks - 1 ? 2 * depth : (int)sizeof blanks - 1;
    const bool array = json_is_array(value),
               broken = array && (json_is_object(json_array_get(value, 0)) || json_is_string(json_array_get(value, 0)));
    if (!json_is_object(value) && !broken) {
        ty_text_add_compact(text, value);
        return;
    }
    const char* comma = "\n";
    ty_text_add_word(text, array ? "[" : "{");
    const char* key;
    size_t i;
    json_t* item;
    if (array) {
        json_array_foreach(value, i, item) {
            ty_text_add_word(text, comma);
            ty_text_add(text, blanks, (size_t)indent + 2);
            print(text, item, depth + 1);
            comma = ",\n";
        }
    } else {
        json_object_foreach((json_t*)value, key, item) {
            ty_text_add_word(text, comma);
            ty_text_add(text, blanks, (size_t)indent + 2);
            ty_text_add_word(text, "\"");
            ty_text_add_word(text, key);
            ty_text_add_word(text, "\": ");
            print(text, item, depth + 1);
            comma = ",\n";
        }
    }
    ty_text_add_word(text, "\n");
    ty_text_add(text, blanks, (size_t)indent);
    ty_text_add_word(text, array ? "]" : "}");
}

/* Takes over geometry and media. */
static json_t* make_root(ty_conversion* conversion, json_t* geometry, json_t* media) {
    json_t* root = json_object();
    bool done = json_object_set_new(root, "tyndall", json_integer(1)) == 0;
    done = json_object_set_new(root, "comment", make_comment(conversion)) == 0 && done;
    if (conversion->camera != NULL) done = json_object_set(root, "camera", conversion->camera) == 0 && done;
    done = json_object_set_new(root, "media", media) == 0 && done;
    done = json_object_set(root, "lights", conversion->lights) == 0 && done;
    done = json_object_set_new(root, "geometry", geometry) == 0 && done;
    if (conversion->render != NULL) done = json_object_set(root, "render", conversion->render) == 0 && done;
    if (done) return root;
    json_decref(root);
    return NULL;
}

ty_result ty_conversion_finish(ty_conversion* conversion, char** text) {
    json_t *geometry = json_array(), *media = json_array();
    char** files = ty_alloc_array(conversion->context, conversion->part_count, sizeof *files, true);
    ty_result result = geometry == NULL || media == NULL ? no_memory(conversion) : TY_OK;
    if (files == NULL) result = TY_ERROR_MEMORY;
    for (size_t i = 0; i < conversion->part_count && result == TY_OK; ++i)
        result = add_part(conversion, (int32_t)i, &files[i], geometry);
    if (result == TY_OK) result = add_spheres(conversion, geometry);
    if (result == TY_OK) result = ty_conversion_place_media(conversion, files, media);
    for (size_t i = 0; i < conversion->part_count && files != NULL; ++i) ty_free_text(conversion->context, files[i]);
    ty_free_array(conversion->context, files, conversion->part_count, sizeof *files);
    if (result != TY_OK) {
        json_decref(geometry);
        json_decref(media);
        return result;
    }
    json_t* root = make_root(conversion, geometry, media);
    if (root == NULL) return no_memory(conversion);
    ty_text written = {.context = conversion->context};
    print(&written, root, 0);
    ty_text_add_word(&written, "\n");
    json_decref(root);
    *text = ty_text_finish(&written);
    return *text != NULL ? TY_OK : TY_ERROR_MEMORY;
}
