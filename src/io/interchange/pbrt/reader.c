/* Directives of pbrt's scene files: their order, the graphics state, and the files that they include. */
#include "base/context.h"
#include "io/file.h"
#include "io/interchange/pbrt/pbrt.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* ---- messages ---- */

void ty_pbrt_location(const ty_pbrt* reader, int32_t file, int32_t line, char* out, size_t size) {
    snprintf(out, size, "%s:%d", reader->sources[file].name, (int)line);
}

ty_result ty_pbrt_fail(const ty_pbrt* reader, int32_t file, int32_t line, const char* format, ...) {
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return ty_fail(reader->context, TY_ERROR_INPUT, "%s:%d: %s", reader->sources[file].name, (int)line, text);
}

ty_result ty_pbrt_refuse(const ty_pbrt_parameters* parameters, const char* format, ...) {
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return ty_pbrt_fail(parameters->reader, parameters->file, parameters->line, "%s", text);
}

/* ---- the stack of states ---- */

static ty_result push(ty_pbrt* reader, const ty_pbrt_text* text, int32_t line, bool transform_only) {
    if (reader->stack_count >= TY_PBRT_STACK_MAX)
        return ty_pbrt_fail(reader, text->file, line, "blocks are nested more than %d deep", (int)TY_PBRT_STACK_MAX);
    if (!ty_grow_array(reader->context, (void**)&reader->stack, &reader->stack_capacity, reader->stack_count,
                       sizeof *reader->stack))
        return TY_ERROR_MEMORY;
    reader->stack[reader->stack_count] = reader->stack[reader->stack_count - 1];
    reader->stack[reader->stack_count - 1].transform_only = transform_only;
    ++reader->stack_count;
    return TY_OK;
}

static ty_result pop(ty_pbrt* reader, const ty_pbrt_text* text, int32_t line) {
    if (reader->stack_count < 2) return ty_pbrt_fail(reader, text->file, line, "an end has no begin");
    --reader->stack_count;
    ty_pbrt_state* below = ty_pbrt_now(reader);
    if (below->transform_only) { /* all but the transform goes on */
        const ty_affine ctm = below->ctm;
        *below = reader->stack[reader->stack_count];
        below->ctm = ctm;
    }
    return TY_OK;
}

/* ---- names ---- */

static ty_result read_name(ty_pbrt* reader, ty_pbrt_text* text, char out[TY_PBRT_NAME_SIZE]) {
    const ty_pbrt_token token = ty_pbrt_next(text);
    if (token.kind != TY_PBRT_STRING || token.length >= TY_PBRT_NAME_SIZE)
        return ty_pbrt_fail(reader, text->file, token.line, "a name of less than %d bytes in quotes should stand here",
                            (int)TY_PBRT_NAME_SIZE);
    snprintf(out, TY_PBRT_NAME_SIZE, "%.*s", (int)token.length, token.text);
    return TY_OK;
}

int32_t ty_pbrt_find_name(const ty_pbrt_name* names, size_t count, const char* name) {
    while (count-- > 0)
        if (strcmp(names[count].name, name) == 0) return names[count].index;
    return -1;
}

static ty_result add_name(ty_pbrt* reader, ty_pbrt_name** names, size_t* count, size_t* capacity, const char* name,
                          int32_t index) {
    if (!ty_grow_array(reader->context, (void**)names, capacity, *count, sizeof **names)) return TY_ERROR_MEMORY;
    ty_pbrt_name* added = &(*names)[(*count)++];
    snprintf(added->name, sizeof added->name, "%s", name);
    added->index = index;
    return TY_OK;
}

static ty_result add_frame(ty_pbrt* reader, const char* name, const ty_affine* ctm) {
    if (!ty_grow_array(reader->context, (void**)&reader->frames, &reader->frame_capacity, reader->frame_count,
                       sizeof *reader->frames))
        return TY_ERROR_MEMORY;
    ty_pbrt_frame* frame = &reader->frames[reader->frame_count++];
    snprintf(frame->name, sizeof frame->name, "%s", name);
    frame->ctm = *ctm;
    return TY_OK;
}

/* ---- directives ---- */

/* A directive with a type and parameters, to which those of Attribute are added. */
static ty_result read_call(ty_pbrt* reader, ty_pbrt_text* text, int32_t line, int target, bool typed,
                           ty_pbrt_parameters* out) {
    *out = (ty_pbrt_parameters){.reader = reader, .file = text->file, .line = line};
    ty_result result = typed ? read_name(reader, text, out->type) : TY_OK;
    if (result == TY_OK) result = ty_pbrt_read_parameters(reader, text, out);
    const ty_pbrt_state* state = ty_pbrt_now(reader);
    const size_t own = out->count;
    for (int32_t i = target < TY_PBRT_TARGETS ? state->attribute_counts[target] : 0; i-- > 0 && result == TY_OK;) {
        ty_pbrt_text attribute = state->attributes[target][i];
        result = ty_pbrt_read_parameters(reader, &attribute, out);
    }
    for (size_t i = own; i < out->count; ++i) out->items[i].used = true; /* they need not apply to all */
    return result;
}

static ty_result read_attribute(ty_pbrt* reader, ty_pbrt_text* text, int32_t line) {
    static const char* const targets[TY_PBRT_TARGETS] = {"shape", "light", "material", "medium", "texture"};
    char name[TY_PBRT_NAME_SIZE];
    ty_result result = read_name(reader, text, name);
    const ty_pbrt_text start = *text;
    ty_pbrt_parameters parameters = {.reader = reader, .file = text->file, .line = line};
    if (result == TY_OK) result = ty_pbrt_read_parameters(reader, text, &parameters);
    ty_pbrt_free_parameters(&parameters);
    if (result != TY_OK) return result;
    for (int target = 0; target < TY_PBRT_TARGETS; ++target) {
        if (strcmp(name, targets[target]) != 0) continue;
        ty_pbrt_state* state = ty_pbrt_now(reader);
        if (state->attribute_counts[target] == TY_PBRT_ATTRIBUTES_MAX)
            return ty_pbrt_fail(reader, text->file, line, "there are more than %d Attribute directives for one kind",
                                (int)TY_PBRT_ATTRIBUTES_MAX);
        state->attributes[target][state->attribute_counts[target]++] = start;
        return TY_OK;
    }
    return ty_pbrt_fail(reader, text->file, line, "Attribute \"%s\" is not known", name);
}

/* With files left out, what they define may be missing, too, and is left out with a note. */
static bool is_missing(ty_pbrt* reader, const char* kind, const char* name) {
    if (reader->conversion->partial)
        ty_conversion_leave_out(reader->conversion, "the %s \"%s\", which is not defined", kind, name);
    return reader->conversion->partial;
}

static ty_result read_medium_interface(ty_pbrt* reader, ty_pbrt_text* text) {
    char names[2][TY_PBRT_NAME_SIZE];
    int32_t media[2];
    ty_result result = read_name(reader, text, names[0]);
    ty_pbrt_text ahead = *text;
    if (ty_pbrt_next(&ahead).kind == TY_PBRT_STRING && result == TY_OK)
        result = read_name(reader, text, names[1]);
    else
        memcpy(names[1], names[0], sizeof names[0]);
    for (int side = 0; side < 2 && result == TY_OK; ++side) {
        media[side] = ty_pbrt_find_name(reader->media, reader->medium_count, names[side]);
        if (media[side] < 0 && names[side][0] != '\0' && !is_missing(reader, "medium", names[side]))
            result = ty_pbrt_fail(reader, text->file, text->line, "the medium \"%s\" is not defined", names[side]);
    }
    if (result != TY_OK) return result;
    ty_pbrt_now(reader)->inside = media[0];
    ty_pbrt_now(reader)->outside = media[1];
    return TY_OK;
}

/* Makes the world right-handed: the camera's x axis should point to the right of its view. */
static ty_result begin_world(ty_pbrt* reader, const ty_pbrt_text* text, int32_t line) {
    if (reader->world) return ty_pbrt_fail(reader, text->file, line, "WorldBegin stands here again");
    reader->world = true;
    if (!reader->has_camera) {
        ty_conversion_approximate(reader->conversion, "there is no camera; one at the origin looks along +z");
        const ty_pbrt_parameters none = {.reader = reader, .file = text->file, .line = line, .type = "perspective"};
        const ty_result result = ty_pbrt_camera(reader, &none);
        if (result != TY_OK) return result;
    }
    ty_pbrt_now(reader)->ctm = ty_affine_identity();
    reader->later_time = false;
    return add_frame(reader, "world", &ty_pbrt_now(reader)->ctm);
}

static ty_result begin_object(ty_pbrt* reader, ty_pbrt_text* text, int32_t line) {
    char name[TY_PBRT_NAME_SIZE];
    ty_result result = read_name(reader, text, name);
    if (result == TY_OK && reader->in_object)
        return ty_pbrt_fail(reader, text->file, line, "ObjectBegin stands within an object");
    if (result == TY_OK) result = push(reader, text, line, false);
    if (result != TY_OK) return result;
    if (!ty_grow_array(reader->context, (void**)&reader->objects, &reader->object_capacity, reader->object_count,
                       sizeof *reader->objects))
        return TY_ERROR_MEMORY;
    ty_pbrt_object* object = &reader->objects[reader->object_count++];
    snprintf(object->name, sizeof object->name, "%s", name);
    object->first = reader->recorded_count;
    object->count = 0;
    reader->in_object = true;
    return TY_OK;
}

static ty_result end_object(ty_pbrt* reader, const ty_pbrt_text* text, int32_t line) {
    if (!reader->in_object) return ty_pbrt_fail(reader, text->file, line, "ObjectEnd has no begin");
    reader->in_object = false;
    ty_pbrt_object* object = &reader->objects[reader->object_count - 1];
    object->count = reader->recorded_count - object->first;
    return pop(reader, text, line);
}

static ty_result read_instance(ty_pbrt* reader, ty_pbrt_text* text, int32_t line) {
    char name[TY_PBRT_NAME_SIZE];
    const ty_result result = read_name(reader, text, name);
    if (result != TY_OK) return result;
    if (reader->in_object) return ty_pbrt_fail(reader, text->file, line, "ObjectInstance stands within an object");
    for (size_t i = reader->object_count; i-- > 0;)
        if (strcmp(reader->objects[i].name, name) == 0) return ty_pbrt_instance(reader, &reader->objects[i]);
    if (is_missing(reader, "object", name)) return TY_OK;
    return ty_pbrt_fail(reader, text->file, line, "the object \"%s\" is not defined", name);
}

static ty_result read_texture(ty_pbrt* reader, ty_pbrt_text* text, int32_t line) {
    char name[TY_PBRT_NAME_SIZE], kind[TY_PBRT_NAME_SIZE];
    ty_pbrt_parameters parameters = {.reader = reader};
    ty_result result = read_name(reader, text, name);
    if (result == TY_OK) result = read_name(reader, text, kind);
    if (result == TY_OK && strcmp(kind, "float") != 0 && strcmp(kind, "spectrum") != 0)
        return ty_pbrt_fail(reader, text->file, line, "a texture of \"%s\" is neither float nor spectrum", kind);
    if (result == TY_OK) result = read_call(reader, text, line, TY_PBRT_TEXTURES, true, &parameters);
    if (result == TY_OK) result = ty_pbrt_read_texture(reader, &parameters, name, strcmp(kind, "float") == 0);
    if (result == TY_OK) ty_pbrt_note_unused(&parameters, "Texture");
    ty_pbrt_free_parameters(&parameters);
    return result;
}

/* MakeNamedMaterial and MakeNamedMedium, whose type is a parameter. */
static ty_result read_named(ty_pbrt* reader, ty_pbrt_text* text, int32_t line, bool medium) {
    char name[TY_PBRT_NAME_SIZE];
    int32_t index = -1;
    ty_pbrt_parameters parameters = {.reader = reader};
    ty_result result = read_name(reader, text, name);
    if (result == TY_OK)
        result = read_call(reader, text, line, medium ? TY_PBRT_MEDIUM : TY_PBRT_MATERIAL, false, &parameters);
    if (result == TY_OK && !ty_pbrt_string(&parameters, "type", parameters.type, sizeof parameters.type))
        result = ty_pbrt_fail(reader, text->file, line, "\"%s\" has no \"string type\"", name);
    if (result == TY_OK && medium) {
        result = ty_pbrt_medium(reader, &parameters, name);
        index = (int32_t)reader->conversion->medium_count - 1;
    } else if (result == TY_OK) {
        result = ty_pbrt_material(reader, &parameters, &index);
    }
    if (result == TY_OK) ty_pbrt_note_unused(&parameters, medium ? "medium" : "material");
    ty_pbrt_free_parameters(&parameters);
    if (result != TY_OK) return result;
    return medium
               ? add_name(reader, &reader->media, &reader->medium_count, &reader->medium_capacity, name, index)
               : add_name(reader, &reader->materials, &reader->material_count, &reader->material_capacity, name, index);
}

static ty_result use_named_material(ty_pbrt* reader, ty_pbrt_text* text, int32_t line) {
    char name[TY_PBRT_NAME_SIZE];
    const ty_result result = read_name(reader, text, name);
    if (result != TY_OK) return result;
    for (size_t i = reader->material_count; i-- > 0;) {
        if (strcmp(reader->materials[i].name, name) != 0) continue;
        ty_pbrt_now(reader)->material = reader->materials[i].index;
        return TY_OK;
    }
    if (is_missing(reader, "material", name)) return TY_OK;
    return ty_pbrt_fail(reader, text->file, line, "the material \"%s\" is not defined", name);
}

static ty_result ignore_call(ty_pbrt* reader, const ty_pbrt_parameters* parameters) {
    (void)reader;
    for (size_t i = 0; i < parameters->count; ++i) parameters->items[i].used = true;
    return TY_OK;
}

static ty_result use_material(ty_pbrt* reader, const ty_pbrt_parameters* parameters) {
    return ty_pbrt_material(reader, parameters, &ty_pbrt_now(reader)->material);
}

/* Directives with a type and parameters. */
static const struct {
    const char* word;
    int target; /* of Attribute */
    ty_result (*handle)(ty_pbrt* reader, const ty_pbrt_parameters* parameters);
    int place; /* 0 anywhere, 1 before WorldBegin, 2 after it */
} calls[] = {
    {"Shape", TY_PBRT_SHAPE, ty_pbrt_shape, 2},           {"LightSource", TY_PBRT_LIGHTS, ty_pbrt_light, 2},
    {"AreaLightSource", TY_PBRT_LIGHTS, ty_pbrt_area, 2}, {"Material", TY_PBRT_MATERIAL, use_material, 2},
    {"Camera", TY_PBRT_TARGETS, ty_pbrt_camera, 1},       {"Film", TY_PBRT_TARGETS, ty_pbrt_film, 1},
    {"Sampler", TY_PBRT_TARGETS, ty_pbrt_sampler, 1},     {"Integrator", TY_PBRT_TARGETS, ty_pbrt_integrator, 1},
    {"PixelFilter", TY_PBRT_TARGETS, ignore_call, 1},     {"Accelerator", TY_PBRT_TARGETS, ignore_call, 1}};

static ty_result read_typed(ty_pbrt* reader, ty_pbrt_text* text, const ty_pbrt_token* word, bool* known) {
    *known = false;
    for (size_t i = 0; i < sizeof calls / sizeof calls[0]; ++i) {
        if (!ty_pbrt_is(word, calls[i].word)) continue;
        *known = true;
        if (calls[i].place != 0 && (calls[i].place == 2) != reader->world)
            return ty_pbrt_fail(reader, text->file, word->line, "%s stands %s WorldBegin", calls[i].word,
                                reader->world ? "after" : "before");
        ty_pbrt_parameters parameters;
        ty_result result = read_call(reader, text, word->line, calls[i].target, true, &parameters);
        if (result == TY_OK) result = calls[i].handle(reader, &parameters);
        if (result == TY_OK) ty_pbrt_note_unused(&parameters, calls[i].word);
        ty_pbrt_free_parameters(&parameters);
        return result;
    }
    return TY_OK;
}

static ty_result read_text(ty_pbrt* reader, const char* bytes, size_t size);

/* Included text acts on the state; imported text keeps its own. */
static ty_result include(ty_pbrt* reader, ty_pbrt_text* text, int32_t line, bool import) {
    const ty_pbrt_token token = ty_pbrt_next(text);
    char location[512], name[1024];
    if (token.kind != TY_PBRT_STRING || token.length >= sizeof name)
        return ty_pbrt_fail(reader, text->file, line, "the name of a file should stand here");
    snprintf(name, sizeof name, "%.*s", (int)token.length, token.text);
    if (reader->depth >= TY_PBRT_DEPTH_MAX)
        return ty_pbrt_fail(reader, text->file, line, "files are included more than %d deep", (int)TY_PBRT_DEPTH_MAX);
    ty_pbrt_location(reader, text->file, line, location, sizeof location);
    uint8_t* bytes = NULL;
    size_t size = 0;
    ty_result result = ty_conversion_read_file(reader->conversion, location, name, &bytes, &size);
    if (result != TY_OK || bytes == NULL) return result;
    if (!ty_grow_array(reader->context, (void**)&reader->sources, &reader->source_capacity, reader->source_count,
                       sizeof *reader->sources)) {
        ty_free_file(reader->context, bytes, size);
        return TY_ERROR_MEMORY;
    }
    reader->sources[reader->source_count++] = (ty_pbrt_source){ty_copy_text(reader->context, name), bytes, size};
    if (reader->sources[reader->source_count - 1].name == NULL) return TY_ERROR_MEMORY;
    ++reader->depth;
    if (import) result = push(reader, text, line, false);
    if (result == TY_OK) result = read_text(reader, (const char*)bytes, size);
    if (result == TY_OK && import) result = pop(reader, text, line);
    --reader->depth;
    return result;
}

/* ActiveTransform: what moves is taken at the start time. */
static ty_result read_active(ty_pbrt* reader, ty_pbrt_text* text, int32_t line) {
    const ty_pbrt_token token = ty_pbrt_next(text);
    if (!ty_pbrt_is(&token, "StartTime") && !ty_pbrt_is(&token, "EndTime") && !ty_pbrt_is(&token, "All"))
        return ty_pbrt_fail(reader, text->file, line, "ActiveTransform is none of StartTime, EndTime and All");
    reader->later_time = ty_pbrt_is(&token, "EndTime");
    if (reader->later_time) ty_conversion_leave_out(reader->conversion, "motion: the scene is that of the start time");
    return TY_OK;
}

static ty_result read_color_space(ty_pbrt* reader, ty_pbrt_text* text, int32_t line) {
    char name[TY_PBRT_NAME_SIZE];
    double rgb[3] = {1, 1, 1};
    const ty_result result = read_name(reader, text, name);
    if (result != TY_OK) return result;
    if (!ty_colour_from_space(name, rgb))
        return ty_pbrt_fail(reader, text->file, line, "the colour space \"%s\" is not known", name);
    snprintf(ty_pbrt_now(reader)->color_space, sizeof ty_pbrt_now(reader)->color_space, "%.15s", name);
    return TY_OK;
}

static ty_result read_frame(ty_pbrt* reader, ty_pbrt_text* text, int32_t line, bool use) {
    char name[TY_PBRT_NAME_SIZE];
    const ty_result result = read_name(reader, text, name);
    if (result != TY_OK) return result;
    if (!use) return add_frame(reader, name, &ty_pbrt_now(reader)->ctm);
    for (size_t i = reader->frame_count; i-- > 0;) {
        if (strcmp(reader->frames[i].name, name) != 0) continue;
        ty_pbrt_now(reader)->ctm = reader->frames[i].ctm;
        return TY_OK;
    }
    return ty_pbrt_fail(reader, text->file, line, "the coordinate system \"%s\" is not defined", name);
}

/* An option, "type name" or "name" and its value, has no effect on what is converted. */
static ty_result skip_option(ty_pbrt* reader, ty_pbrt_text* text, int32_t line) {
    ty_pbrt_token token = ty_pbrt_next(text);
    if (token.kind == TY_PBRT_STRING) token = ty_pbrt_next(text);
    if (token.kind == TY_PBRT_OPEN)
        while (token.kind != TY_PBRT_CLOSE && token.kind != TY_PBRT_END) token = ty_pbrt_next(text);
    if (token.kind != TY_PBRT_END && token.kind != TY_PBRT_BROKEN) return TY_OK;
    return ty_pbrt_fail(reader, text->file, line, "Option has no name and value");
}

static ty_result read_block(ty_pbrt* reader, ty_pbrt_text* text, const ty_pbrt_token* word) {
    const int32_t line = word->line;
    if (ty_pbrt_is(word, "AttributeBegin")) return push(reader, text, line, false);
    if (ty_pbrt_is(word, "TransformBegin")) return push(reader, text, line, true);
    if (ty_pbrt_is(word, "AttributeEnd") || ty_pbrt_is(word, "TransformEnd")) return pop(reader, text, line);
    if (ty_pbrt_is(word, "WorldBegin")) return begin_world(reader, text, line);
    if (ty_pbrt_is(word, "WorldEnd")) return TY_OK; /* of version 3 */
    if (ty_pbrt_is(word, "ObjectBegin")) return begin_object(reader, text, line);
    if (ty_pbrt_is(word, "ObjectEnd")) return end_object(reader, text, line);
    if (ty_pbrt_is(word, "ObjectInstance")) return read_instance(reader, text, line);
    if (ty_pbrt_is(word, "Include")) return include(reader, text, line, false);
    if (ty_pbrt_is(word, "Import")) return include(reader, text, line, true);
    if (ty_pbrt_is(word, "Attribute")) return read_attribute(reader, text, line);
    if (ty_pbrt_is(word, "MediumInterface")) return read_medium_interface(reader, text);
    if (ty_pbrt_is(word, "Texture")) return read_texture(reader, text, line);
    if (ty_pbrt_is(word, "MakeNamedMaterial")) return read_named(reader, text, line, false);
    if (ty_pbrt_is(word, "MakeNamedMedium")) return read_named(reader, text, line, true);
    if (ty_pbrt_is(word, "NamedMaterial")) return use_named_material(reader, text, line);
    if (ty_pbrt_is(word, "CoordinateSystem")) return read_frame(reader, text, line, false);
    if (ty_pbrt_is(word, "CoordSysTransform")) return read_frame(reader, text, line, true);
    if (ty_pbrt_is(word, "ActiveTransform")) return read_active(reader, text, line);
    if (ty_pbrt_is(word, "ColorSpace")) return read_color_space(reader, text, line);
    if (ty_pbrt_is(word, "Option")) return skip_option(reader, text, line);
    if (ty_pbrt_is(word, "ReverseOrientation")) {
        ty_pbrt_now(reader)->reverse = !ty_pbrt_now(reader)->reverse;
        return TY_OK;
    }
    if (ty_pbrt_is(word, "TransformTimes")) {
        double times[2];
        return ty_pbrt_numbers(reader, text, 2, times);
    }
    return ty_pbrt_fail(reader, text->file, line, "the directive \"%.*s\" is not known",
                        (int)(word->length < 60 ? word->length : 60), word->text);
}

/* The last source is that of the text. */
static ty_result read_text(ty_pbrt* reader, const char* bytes, size_t size) {
    ty_pbrt_text text = {bytes, bytes + size, 1, (int32_t)reader->source_count - 1};
    ty_result result = TY_OK;
    while (result == TY_OK) {
        const ty_pbrt_token word = ty_pbrt_next(&text);
        bool known = true;
        if (word.kind == TY_PBRT_END) break;
        if (word.kind != TY_PBRT_WORD)
            return ty_pbrt_fail(reader, text.file, word.line, "a directive should stand here");
        result = ty_pbrt_transform(reader, &text, &word, &known);
        if (result == TY_OK && !known) result = read_typed(reader, &text, &word, &known);
        if (result == TY_OK && !known) result = read_block(reader, &text, &word);
    }
    return result;
}

/* ---- begin and end ---- */

static void close_reader(ty_pbrt* reader) {
    ty_context* context = reader->context;
    for (size_t i = 0; i < reader->source_count; ++i) {
        ty_free_text(context, reader->sources[i].name);
        if (reader->sources[i].bytes != NULL) ty_free_file(context, reader->sources[i].bytes, reader->sources[i].size);
    }
    for (size_t i = 0; i < reader->texture_count; ++i) ty_free_text(context, reader->textures[i].file);
    ty_free_array(context, reader->sources, reader->source_capacity, sizeof *reader->sources);
    ty_free_array(context, reader->stack, reader->stack_capacity, sizeof *reader->stack);
    ty_free_array(context, reader->textures, reader->texture_capacity, sizeof *reader->textures);
    ty_free_array(context, reader->materials, reader->material_capacity, sizeof *reader->materials);
    ty_free_array(context, reader->media, reader->medium_capacity, sizeof *reader->media);
    ty_free_array(context, reader->frames, reader->frame_capacity, sizeof *reader->frames);
    ty_free_array(context, reader->objects, reader->object_capacity, sizeof *reader->objects);
    ty_free_array(context, reader->recorded, reader->recorded_capacity, sizeof *reader->recorded);
}

/* The state at the start: a diffuse material of reflectance 0.5. */
static ty_result open_reader(ty_pbrt* reader, const char* name) {
    ty_pbrt_parameters material = {.reader = reader, .type = "diffuse"};
    if (!ty_grow_array(reader->context, (void**)&reader->sources, &reader->source_capacity, 0,
                       sizeof *reader->sources) ||
        !ty_grow_array(reader->context, (void**)&reader->stack, &reader->stack_capacity, 0, sizeof *reader->stack))
        return TY_ERROR_MEMORY;
    reader->sources[reader->source_count++] = (ty_pbrt_source){ty_copy_text(reader->context, name), NULL, 0};
    if (reader->sources[0].name == NULL) return TY_ERROR_MEMORY;
    reader->stack[reader->stack_count++] = (ty_pbrt_state){.ctm = ty_affine_identity(), .inside = -1, .outside = -1};
    snprintf(reader->stack[0].color_space, sizeof reader->stack[0].color_space, "srgb");
    reader->mirror = ty_affine_identity();
    reader->exposure_time = 1;
    reader->iso = 100;
    return ty_pbrt_material(reader, &material, &reader->stack[0].material);
}

ty_result ty_read_pbrt(ty_conversion* conversion, const char* text, size_t size) {
    ty_pbrt reader = {.conversion = conversion, .context = conversion->context};
    ty_result result = open_reader(&reader, conversion->input);
    if (result == TY_OK) result = read_text(&reader, text, size);
    if (result == TY_OK && !reader.world)
        result = ty_fail(conversion->context, TY_ERROR_INPUT, "%s: there is no WorldBegin", conversion->input);
    if (result == TY_OK) result = ty_pbrt_finish_camera(&reader);
    close_reader(&reader);
    return result;
}
