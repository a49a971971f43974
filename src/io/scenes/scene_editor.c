#include "io/scenes/scene_editor.h"

#include "base/context.h"
#include "io/json_edit.h"
#include "io/json_patch.h"
#include "io/json_text.h"
#include "io/scenes/memory_files.h"
#include "io/schema_text.h"
#include "io/scenes/scene_reader.h"
#include "io/scenes/scene_schema.h"
#include "scene/scene.h"

#include <string.h>

enum { PATH_SIZE = 512, ALL_SECTIONS = (1 << TY_SECTIONS) - 1 };

struct ty_scene_editor {
    ty_context* context;
    char* name;
    ty_scene_source source;
    json_t* schema;
    json_t* opened; /* the file's document, without overrides */
    json_t* root;   /* the document after overrides and edits */
    char* text;
    ty_asset_cache assets;
    ty_file_digests files[TY_SECTIONS];
    size_t listed_lights; /* lights of the scene before those of meshes' files */
    unsigned replaced;    /* bits of the sections that may show content in memory which was replaced since */
    ty_scene* scene;
};

/* ---- readings ---- */

static ty_scene_reader start_reading(ty_scene_editor* editor) {
    ++editor->assets.reading;
    return (ty_scene_reader){.context = editor->context,
                             .clean = !ty_has_error(editor->context),
                             .name = editor->name,
                             .folder = editor->source.folder,
                             .schema = editor->schema,
                             .assets = &editor->assets};
}

/* Releases what the reader still has. */
static void end_reading(ty_scene_reader* reader) {
    ty_scene_destroy(reader->scene);
    ty_free_digests(reader);
    json_decref(reader->root);
}

static char* compact_text(ty_context* context, const json_t* root) {
    ty_text text = {.context = context};
    ty_text_add_compact(&text, root);
    return ty_text_finish(&text);
}

/* Takes over the reader's document, and the digests of the sections that it read. */
static void exchange_document(ty_scene_editor* editor, ty_scene_reader* reader, unsigned sections, char* text) {
    json_t* root = editor->root;
    editor->root = reader->root;
    reader->root = root;
    for (int s = 0; s < TY_SECTIONS; ++s) {
        if ((sections & 1u << s) == 0) continue;
        const ty_file_digests files = editor->files[s];
        editor->files[s] = reader->files[s];
        reader->files[s] = files;
    }
    if ((sections & 1u << TY_SECTION_LIGHTS) != 0) editor->listed_lights = reader->listed_lights;
    ty_free_text(editor->context, editor->text);
    editor->text = text;
}

/* Hash and text of the reader's document, of which it has read some sections. */
static ty_result describe(const ty_scene_editor* editor, const ty_scene_reader* reader, unsigned sections,
                          uint64_t* hash, char** text) {
    ty_file_digests files[TY_SECTIONS];
    for (int s = 0; s < TY_SECTIONS; ++s) files[s] = (sections & 1u << s) != 0 ? reader->files[s] : editor->files[s];
    const ty_result result = ty_reader_hash(reader, files, hash);
    if (result != TY_OK) return result;
    *text = compact_text(editor->context, reader->root);
    return *text != NULL ? TY_OK : TY_ERROR_MEMORY;
}

/* Exchanges the scene for the reader's, after a commit. */
static ty_result exchange_scene(ty_scene_editor* editor, ty_scene_reader* reader) {
    const ty_result result = ty_reader_commit(reader);
    if (result != TY_OK) return result;
    ty_scene* scene = editor->scene;
    editor->scene = reader->scene;
    reader->scene = scene;
    return TY_OK;
}

/* Exchanges the parts of the scene that the reader has read: shapes and meshes, with their lights, stay. */
static ty_result exchange_parts(ty_scene_editor* editor, ty_scene_reader* reader, unsigned sections) {
    unsigned parts = TY_SCENE_SETTINGS;
    ty_result result = TY_OK;
    if ((sections & 1u << TY_SECTION_CAMERA) != 0) parts |= TY_SCENE_CAMERA;
    if ((sections & 1u << TY_SECTION_MEDIA) != 0) parts |= TY_SCENE_MEDIA;
    if ((sections & 1u << TY_SECTION_LIGHTS) != 0) {
        parts |= TY_SCENE_LIGHTS;
        result = ty_scene_copy_lights(editor->scene, editor->listed_lights, reader->scene);
    }
    return result == TY_OK ? ty_scene_replace(editor->scene, reader->scene, parts) : result;
}

/* Makes the reader's document the editor's: reads and commits the sections whose bits are set. */
static ty_result build(ty_scene_editor* editor, ty_scene_reader* reader, unsigned sections) {
    uint64_t hash = 0;
    char* text = NULL;
    ty_result result = ty_read_sections(reader, sections);
    if (result == TY_OK) result = describe(editor, reader, sections, &hash, &text);
    if (result == TY_OK)
        result = sections == ALL_SECTIONS ? exchange_scene(editor, reader) : exchange_parts(editor, reader, sections);
    if (result != TY_OK) {
        ty_free_text(editor->context, text);
        return result;
    }
    ty_scene_set_hash(editor->scene, hash);
    exchange_document(editor, reader, sections, text);
    return TY_OK;
}

/* ---- opening ---- */

static ty_result load(ty_scene_editor* editor, const char* const* overrides, int32_t count) {
    ty_scene_reader reader = start_reading(editor);
    reader.text = editor->source.text;
    reader.length = editor->source.length;
    ty_result result = ty_reader_parse(&reader);
    if (result == TY_OK) {
        editor->opened = json_deep_copy(reader.root);
        if (editor->opened == NULL) result = ty_fail(editor->context, TY_ERROR_MEMORY, "not enough memory");
    }
    if (result == TY_OK) result = ty_apply_overrides(&reader, overrides, count);
    if (result == TY_OK) result = ty_reader_check(&reader, NULL);
    if (result == TY_OK) result = build(editor, &reader, ALL_SECTIONS);
    ty_free_overrides(&reader);
    end_reading(&reader);
    return result;
}

/* An editor of an opened source, which is taken over, also on failure. */
static ty_result open_editor(ty_context* context, const char* name, ty_scene_source* source,
                             const char* const* overrides, int32_t override_count, ty_scene_editor** out) {
    ty_scene_editor* editor = ty_alloc_array(context, 1, sizeof *editor, true);
    if (editor == NULL) {
        ty_close_source(context, source);
        return TY_ERROR_MEMORY;
    }
    editor->context = editor->assets.context = context;
    editor->source = *source;
    ty_result result = TY_OK;
    editor->name = ty_copy_text(context, name);
    if (editor->name == NULL) result = TY_ERROR_MEMORY;
    if (result == TY_OK) {
        editor->schema = ty_scene_schema_tree();
        if (editor->schema == NULL) result = ty_fail(context, TY_ERROR_MEMORY, "not enough memory for the schema");
    }
    if (result == TY_OK) result = load(editor, overrides, override_count);
    if (result == TY_OK)
        *out = editor;
    else
        ty_scene_editor_close(editor);
    return result;
}

ty_result ty_scene_editor_open(ty_context* context, const char* path, const char* const* overrides,
                               int32_t override_count, ty_scene_editor** out) {
    if (context == NULL || path == NULL || out == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_scene_editor_open: context, path or out is NULL");
    ty_scene_source source;
    const ty_result result = ty_open_source(context, path, &source);
    if (result != TY_OK) {
        ty_close_source(context, &source);
        return result;
    }
    return open_editor(context, path, &source, overrides, override_count, out);
}

ty_result ty_scene_editor_open_text(ty_context* context, const char* text, size_t length, const char* name,
                                    const char* folder, const char* const* overrides, int32_t override_count,
                                    ty_scene_editor** out) {
    if (context == NULL || text == NULL || out == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_scene_editor_open_text: context, text or out is NULL");
    ty_scene_source source;
    const ty_result result = ty_copy_source(context, text, length, folder, &source);
    return result == TY_OK
               ? open_editor(context, name != NULL ? name : "scene", &source, overrides, override_count, out)
               : result;
}

void ty_scene_editor_close(ty_scene_editor* editor) {
    if (editor == NULL) return;
    ty_context* context = editor->context;
    ty_scene_destroy(editor->scene);
    ty_assets_release(&editor->assets);
    for (int s = 0; s < TY_SECTIONS; ++s)
        ty_free_array(context, editor->files[s].values, editor->files[s].capacity, sizeof(uint64_t));
    ty_free_text(context, editor->text);
    ty_free_text(context, editor->name);
    ty_close_source(context, &editor->source);
    json_decref(editor->schema);
    json_decref(editor->opened);
    json_decref(editor->root);
    ty_free_array(context, editor, 1, sizeof *editor);
}

const ty_scene* ty_scene_editor_scene(const ty_scene_editor* editor) {
    return editor->scene;
}

const char* ty_scene_editor_text(const ty_scene_editor* editor) {
    return editor->text;
}

/* ---- edits ---- */

static ty_result fail_change(ty_context* context, const ty_scene_change* change, const char* reason) {
    char text[PATH_SIZE] = "";
    ty_append(text, sizeof text, "%s", change->path);
    for (char* at = text; *at != '\0'; ++at)
        if ((unsigned char)*at < ' ' || *at == 0x7f) *at = '?';
    return ty_fail(context, TY_ERROR_ARGUMENT, "%s: %s", text, reason);
}

ty_result ty_change_document(ty_context* context, json_t* root, const ty_scene_change* change) {
    if (change->path == NULL) return ty_fail(context, TY_ERROR_ARGUMENT, "a change has no path");
    char keys[PATH_SIZE], reason[256];
    ty_json_path path;
    const size_t length = strlen(change->path);
    if (length < sizeof keys) memcpy(keys, change->path, length + 1);
    if (length >= sizeof keys || !ty_json_parse_path(keys, &path))
        return fail_change(context, change, "expected a path such as media[0].g");
    json_t* value =
        change->value == NULL ? json_null() : json_loads(change->value, JSON_DECODE_ANY | JSON_REJECT_DUPLICATES, NULL);
    if (value == NULL) return fail_change(context, change, "the value is not valid JSON");
    switch (ty_json_put(root, &path, value, reason, sizeof reason)) {
    case TY_JSON_PUT: return TY_OK;
    case TY_JSON_REFUSED: return fail_change(context, change, reason);
    case TY_JSON_NO_MEMORY: break;
    }
    return ty_fail(context, TY_ERROR_MEMORY, "not enough memory for a change");
}

/* A copy of the document with all changes. */
static ty_result change_copy(ty_scene_editor* editor, const ty_scene_change* changes, int32_t count, json_t** out) {
    *out = json_deep_copy(editor->root);
    if (*out == NULL) return ty_fail(editor->context, TY_ERROR_MEMORY, "not enough memory for a change");
    ty_result result = TY_OK;
    for (int32_t i = 0; i < count && result == TY_OK; ++i)
        result = ty_change_document(editor->context, *out, &changes[i]);
    if (result != TY_OK) return result;
    json_t* same = ty_json_keep_same(editor->opened, *out); /* numbers are written as in the file */
    json_decref(*out);
    *out = same;
    return same != NULL ? TY_OK : ty_fail(editor->context, TY_ERROR_MEMORY, "not enough memory for a change");
}

/* True if the documents differ in a member of one of the keys, a list ended by NULL. */
static bool differ(const json_t* a, const json_t* b, const char* const* keys) {
    for (; *keys != NULL; ++keys)
        if (!ty_json_same(json_object_get(a, *keys), json_object_get(b, *keys))) return true;
    return false;
}

/* The first area light at or after *index, which moves behind it; NULL if there is none. */
static const json_t* next_area_light(const json_t* root, size_t* index) {
    const json_t* lights = json_object_get(root, "lights");
    while (*index < json_array_size(lights)) {
        const json_t* light = json_array_get(lights, (*index)++);
        if (strcmp(json_string_value(json_object_get(light, "type")), "area") == 0) return light;
    }
    return NULL;
}

/* True if the documents have different area lights, which are surfaces, too. */
static bool area_lights_differ(const json_t* a, const json_t* b) {
    size_t i = 0, k = 0;
    const json_t *first, *second;
    do {
        first = next_area_light(a, &i);
        second = next_area_light(b, &k);
        if (!ty_json_same(first, second)) return true;
    } while (first != NULL);
    return false;
}

/* Flags of the parts whose keys differ. */
static uint32_t compare(const json_t* before, const json_t* after) {
    static const char *const render[] = {"render", NULL}, *const camera[] = {"camera", NULL},
                             *const light[] = {"media", "lights", "frame", NULL},
                             *const geometry[] = {"geometry", NULL},
                             *const space[] = {"meters_per_unit", "up_axis", "boundary", NULL};
    uint32_t flags = TY_EDIT_NOTHING;
    if (differ(before, after, render)) flags |= TY_EDIT_RENDER;
    if (differ(before, after, camera)) flags |= TY_EDIT_CAMERA;
    if (differ(before, after, light)) flags |= TY_EDIT_LIGHT;
    if (differ(before, after, geometry) || area_lights_differ(before, after)) flags |= TY_EDIT_GEOMETRY;
    if (differ(before, after, space)) flags |= TY_EDIT_CAMERA | TY_EDIT_LIGHT | TY_EDIT_GEOMETRY;
    return flags;
}

/* True if a sky fills a box with air, which is media. */
static bool has_air(const json_t* root) {
    size_t i;
    json_t* light;
    json_array_foreach(json_object_get(root, "lights"), i, light) {
        if (json_object_get(json_object_get(light, "sky"), "air") != NULL) return true;
    }
    return false;
}

/* Bits of the sections that are read anew. Shapes and meshes are kept or made as a whole, with all that refers to
 * them. */
static unsigned sections_of(const json_t* before, const json_t* after) {
    static const char *const all[] = {"geometry", "meters_per_unit", "up_axis", "boundary", NULL},
                             *const camera[] = {"camera", NULL}, *const media[] = {"media", "frame", NULL},
                             *const lights[] = {"lights", NULL};
    if (differ(before, after, all)) return ALL_SECTIONS;
    unsigned sections = 0;
    if (differ(before, after, camera)) sections |= 1u << TY_SECTION_CAMERA;
    if (differ(before, after, media)) sections |= 1u << TY_SECTION_MEDIA;
    if (differ(before, after, lights)) {
        sections |= 1u << TY_SECTION_LIGHTS;
        if (has_air(before) || has_air(after)) sections |= 1u << TY_SECTION_MEDIA;
    }
    return sections;
}

/* Flags of sections that show other content. */
static uint32_t flags_of(unsigned sections) {
    if (sections == ALL_SECTIONS) return TY_EDIT_LIGHT | TY_EDIT_GEOMETRY;
    return sections != 0 ? TY_EDIT_LIGHT : TY_EDIT_NOTHING;
}

static bool same_camera(const ty_camera_def* a, const ty_camera_def* b) {
    return memcmp(a->position, b->position, sizeof a->position) == 0 &&
           memcmp(a->target, b->target, sizeof a->target) == 0 && memcmp(a->up, b->up, sizeof a->up) == 0 &&
           memcmp(a->resolution, b->resolution, sizeof a->resolution) == 0 && a->fov_y == b->fov_y &&
           a->exposure == b->exposure && memcmp(a->shift, b->shift, sizeof a->shift) == 0 &&
           a->aperture_radius == b->aperture_radius && a->focus_distance == b->focus_distance && a->moves == b->moves &&
           memcmp(a->end_position, b->end_position, sizeof a->end_position) == 0 &&
           memcmp(a->end_target, b->end_target, sizeof a->end_target) == 0 &&
           memcmp(a->end_up, b->end_up, sizeof a->end_up) == 0;
}

/* Makes the scene of a reader's document, which takes the place of the editor's. */
static ty_result follow_document(ty_scene_editor* editor, ty_scene_reader* reader, uint32_t* edited) {
    if (editor->replaced == 0 && json_equal(editor->root, reader->root)) return TY_OK;
    const ty_camera_def camera = ty_scene_camera(editor->scene);
    ty_result result = ty_reader_check(reader, NULL);
    if (result != TY_OK) return result;
    uint32_t flags = compare(editor->root, reader->root) | flags_of(editor->replaced);
    result = build(editor, reader, sections_of(editor->root, reader->root) | editor->replaced);
    if (result != TY_OK) return result;
    editor->replaced = 0;
    const ty_camera_def now = ty_scene_camera(editor->scene);
    if (!same_camera(&camera, &now)) flags |= TY_EDIT_CAMERA; /* that of a geometry's file */
    *edited = flags;
    return TY_OK;
}

ty_result ty_scene_editor_follow(ty_scene_editor* editor, const char* text) {
    uint32_t edited = TY_EDIT_NOTHING;
    ty_scene_reader reader = start_reading(editor);
    reader.bare = true;
    json_t* document = json_loads(text, JSON_REJECT_DUPLICATES, NULL);
    reader.root = document != NULL ? ty_json_keep_same(editor->opened, document) : NULL;
    json_decref(document);
    const ty_result result = reader.root != NULL
                                 ? follow_document(editor, &reader, &edited)
                                 : ty_fail(editor->context, TY_ERROR_INPUT, "a document of an editor cannot be read");
    end_reading(&reader);
    ty_assets_trim(&editor->assets);
    return result;
}

static ty_result apply(ty_scene_editor* editor, const ty_scene_change* changes, int32_t count, uint32_t* edited) {
    ty_scene_reader reader = start_reading(editor);
    reader.bare = true;
    ty_result result = change_copy(editor, changes, count, &reader.root);
    if (result == TY_OK) result = follow_document(editor, &reader, edited);
    end_reading(&reader);
    ty_assets_trim(&editor->assets);
    return result;
}

ty_result ty_scene_editor_apply(ty_scene_editor* editor, const ty_scene_change* changes, int32_t count,
                                uint32_t* edited) {
    uint32_t flags = TY_EDIT_NOTHING;
    if (count < 0 || (count > 0 && changes == NULL))
        return ty_fail(editor->context, TY_ERROR_ARGUMENT, "%d changes, but none are given", (int)count);
    const ty_result result = apply(editor, changes, count, &flags);
    if (edited != NULL) *edited = flags;
    return result;
}

/* ---- content in memory ---- */

ty_result ty_scene_editor_set_volume(ty_scene_editor* editor, const char* name, ty_grid* const* grids, int32_t count) {
    bool replaced = false;
    const ty_result result = ty_memory_set_volume(&editor->assets, name, grids, count, &replaced);
    if (replaced) editor->replaced |= 1u << TY_SECTION_MEDIA;
    return result;
}

ty_result ty_scene_editor_set_mesh(ty_scene_editor* editor, const char* name, const ty_mesh_def* def) {
    bool replaced = false;
    const ty_result result = ty_memory_set_mesh(&editor->assets, name, def, &replaced);
    if (replaced) editor->replaced |= ALL_SECTIONS;
    return result;
}

ty_result ty_scene_editor_set_image(ty_scene_editor* editor, const char* name, const ty_image* image) {
    bool replaced = false;
    const ty_result result = ty_memory_set_image(&editor->assets, name, image, &replaced);
    if (replaced) editor->replaced |= 1u << TY_SECTION_LIGHTS;
    return result;
}

void ty_scene_editor_drop(ty_scene_editor* editor, const char* name) {
    ty_memory_drop(&editor->assets, name);
}

/* ---- saving ---- */

ty_result ty_scene_editor_save_text(const ty_scene_editor* editor, char** out) {
    *out = ty_json_patch(editor->context, editor->source.text, editor->source.length, editor->opened, editor->root);
    return *out != NULL ? TY_OK : TY_ERROR_MEMORY;
}

ty_result ty_scene_editor_overrides(const ty_scene_editor* editor, char*** out, int32_t* count) {
    return ty_json_list_changes(editor->context, editor->opened, editor->root, out, count);
}

void ty_scene_editor_free_overrides(const ty_scene_editor* editor, char** overrides, int32_t count) {
    ty_json_free_changes(editor->context, overrides, count);
}
