/* The elements of a scene, by Expat, with defaults in place and includes taken in. */
#include "io/interchange/mitsuba/mitsuba.h"

#include "base/context.h"
#include "io/file.h"

#include <ctype.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* ---- access ---- */

void ty_mitsuba_location(const ty_mitsuba* scene, int32_t node, char out[TY_MITSUBA_LOCATION_SIZE]) {
    snprintf(out, TY_MITSUBA_LOCATION_SIZE, "%.400s:%d", scene->files[scene->nodes[node].file],
             (int)scene->nodes[node].line);
}

ty_result ty_mitsuba_fail(const ty_mitsuba* scene, int32_t node, const char* format, ...) {
    char text[512], location[TY_MITSUBA_LOCATION_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    ty_mitsuba_location(scene, node, location);
    return ty_fail(scene->context, TY_ERROR_INPUT, "%s: %s", location, text);
}

const char* ty_mitsuba_attribute(const ty_mitsuba* scene, int32_t node, const char* key) {
    const char* at = scene->nodes[node].attributes;
    while (*at != '\0') {
        const char* value = at + strlen(at) + 1;
        if (strcmp(at, key) == 0) return value;
        at = value + strlen(value) + 1;
    }
    return NULL;
}

bool ty_mitsuba_same(const char* a, const char* b) {
    for (;; ++a, ++b) {
        while (*a == '_') ++a;
        while (*b == '_') ++b;
        if (tolower((unsigned char)*a) != tolower((unsigned char)*b)) return false;
        if (*a == '\0') return true;
    }
}

bool ty_mitsuba_is(const ty_mitsuba* scene, int32_t node, const char* tag) {
    return ty_mitsuba_same(scene->nodes[node].tag, tag);
}

const char* ty_mitsuba_type(const ty_mitsuba* scene, int32_t node) {
    const char* type = ty_mitsuba_attribute(scene, node, "type");
    return type != NULL ? type : "";
}

int32_t ty_mitsuba_resolve(const ty_mitsuba* scene, int32_t node) {
    if (!ty_mitsuba_is(scene, node, "ref")) return node;
    const char* wanted = ty_mitsuba_attribute(scene, node, "id");
    for (size_t i = 0; i < scene->node_count && wanted != NULL; ++i) {
        if (ty_mitsuba_is(scene, (int32_t)i, "ref")) continue;
        const char* id = ty_mitsuba_attribute(scene, (int32_t)i, "id");
        if (id != NULL && strcmp(id, wanted) == 0) return (int32_t)i;
    }
    return -1;
}

int32_t ty_mitsuba_child(const ty_mitsuba* scene, int32_t node, const char* name) {
    for (int32_t child = scene->nodes[node].first_child; child >= 0; child = scene->nodes[child].next) {
        const char* own = ty_mitsuba_attribute(scene, child, "name");
        if (own != NULL && ty_mitsuba_same(own, name)) return ty_mitsuba_resolve(scene, child);
    }
    return -1;
}

int32_t ty_mitsuba_child_of_tag(const ty_mitsuba* scene, int32_t node, const char* tag) {
    for (int32_t child = scene->nodes[node].first_child; child >= 0; child = scene->nodes[child].next) {
        const int32_t object = ty_mitsuba_resolve(scene, child);
        if (object >= 0 && ty_mitsuba_is(scene, object, tag)) return object;
    }
    return -1;
}

/* ---- files ---- */

char* ty_mitsuba_file_name(const ty_mitsuba* scene, const char* name) {
    const ty_conversion* conversion = scene->conversion;
    for (size_t i = 0; i < scene->folder_count && conversion->folder != NULL; ++i) {
        char* inner = ty_join_path(scene->context, scene->folders[i], name);
        char* whole = inner != NULL ? ty_join_path(scene->context, conversion->folder, inner) : NULL;
        FILE* file = whole != NULL ? ty_open_regular(whole, &(uint64_t){0}) : NULL;
        ty_free_text(scene->context, whole);
        if (file != NULL) {
            fclose(file);
            return inner;
        }
        ty_free_text(scene->context, inner);
    }
    return ty_copy_text(scene->context, name);
}

ty_result ty_mitsuba_read_file(ty_mitsuba* scene, int32_t node, const char* name, uint8_t** bytes, size_t* size) {
    char location[TY_MITSUBA_LOCATION_SIZE];
    char* found = ty_mitsuba_file_name(scene, name);
    *bytes = NULL;
    if (found == NULL) return TY_ERROR_MEMORY;
    ty_mitsuba_location(scene, node, location);
    const ty_result result = ty_conversion_read_file(scene->conversion, location, found, bytes, size);
    ty_free_text(scene->context, found);
    return result;
}

void ty_mitsuba_free(ty_mitsuba* scene) {
    ty_context* context = scene->context;
    for (size_t i = 0; i < scene->node_count; ++i) {
        ty_free_text(context, scene->nodes[i].tag);
        ty_free_array(context, scene->nodes[i].attributes, scene->nodes[i].attribute_size, 1);
    }
    for (size_t i = 0; i < scene->file_count; ++i) ty_free_text(context, scene->files[i]);
    for (size_t i = 0; i < scene->folder_count; ++i) ty_free_text(context, scene->folders[i]);
    for (size_t i = 0; i < scene->default_count; ++i) {
        ty_free_text(context, scene->defaults[i].name);
        ty_free_text(context, scene->defaults[i].value);
    }
    ty_free_array(context, scene->nodes, scene->node_capacity, sizeof *scene->nodes);
    ty_free_array(context, scene->files, scene->file_capacity, sizeof *scene->files);
    ty_free_array(context, scene->folders, scene->folder_capacity, sizeof *scene->folders);
    ty_free_array(context, scene->defaults, scene->default_capacity, sizeof *scene->defaults);
    ty_free_array(context, scene->bsdfs, scene->bsdf_capacity, sizeof *scene->bsdfs);
    ty_free_array(context, scene->media, scene->medium_capacity, sizeof *scene->media);
}

/* ---- parsing ---- */

#if TYNDALL_EXPAT

#include <expat.h>

enum { NODES_MAX = 1 << 22, NESTED_MAX = 64, INCLUDES_MAX = 16, VALUE_MAX = 4096 };

typedef struct parser {
    ty_mitsuba* scene;
    XML_Parser expat;
    int32_t stack[NESTED_MAX]; /* open elements */
    int depth, includes;
    int32_t file;
    ty_result result;
} parser;

static void stop(parser* p, const char* format, ...) __attribute__((format(printf, 2, 3)));
static void stop(parser* p, const char* format, ...) {
    if (p->result == TY_OK) {
        char text[512];
        va_list arguments;
        va_start(arguments, format);
        vsnprintf(text, sizeof text, format, arguments);
        va_end(arguments);
        p->result = ty_fail(p->scene->context, TY_ERROR_INPUT, "%s:%lu: %s", p->scene->files[p->file],
                            (unsigned long)XML_GetCurrentLineNumber(p->expat), text);
    }
    XML_StopParser(p->expat, XML_FALSE);
}

static void stop_memory(parser* p) {
    p->result = TY_ERROR_MEMORY;
    if (!ty_has_error(p->scene->context)) stop(p, "not enough memory");
    XML_StopParser(p->expat, XML_FALSE);
}

/* Replaces $name by the values of defaults; false after a message. */
static bool substitute(parser* p, const char* value, char out[VALUE_MAX]) {
    size_t used = 0;
    while (*value != '\0') {
        if (used + 1 >= VALUE_MAX) break;
        if (*value != '$') {
            out[used++] = *value++;
            continue;
        }
        const char* name = ++value;
        while (isalnum((unsigned char)*value) || *value == '_') ++value;
        const ty_mitsuba_default* found = NULL;
        for (size_t i = 0; i < p->scene->default_count && found == NULL; ++i)
            if (strncmp(p->scene->defaults[i].name, name, (size_t)(value - name)) == 0 &&
                p->scene->defaults[i].name[value - name] == '\0')
                found = &p->scene->defaults[i];
        if (found == NULL) {
            stop(p, "the parameter \"$%.*s\" has no default", (int)(value - name < 60 ? value - name : 60), name);
            return false;
        }
        used += (size_t)snprintf(out + used, VALUE_MAX - used, "%s", found->value);
        if (used >= VALUE_MAX) break;
    }
    if (used + 1 < VALUE_MAX) {
        out[used] = '\0';
        return true;
    }
    stop(p, "an attribute is longer than %d bytes", (int)VALUE_MAX);
    return false;
}

/* Appends "key\0value\0" to a block that ends with an empty key. */
static bool append(parser* p, ty_mitsuba_node* node, const char* key, const char* value) {
    const size_t key_size = strlen(key) + 1, value_size = strlen(value) + 1, old = node->attribute_size;
    char* grown = ty_alloc_array(p->scene->context, old + key_size + value_size, 1, false);
    if (grown == NULL) return false;
    memcpy(grown, node->attributes, old - 1);
    memcpy(grown + old - 1, key, key_size);
    memcpy(grown + old - 1 + key_size, value, value_size);
    grown[old - 1 + key_size + value_size] = '\0';
    ty_free_array(p->scene->context, node->attributes, old, 1);
    node->attributes = grown;
    node->attribute_size = old + key_size + value_size;
    return true;
}

static int32_t add_node(parser* p, const char* tag) {
    ty_mitsuba* scene = p->scene;
    if (scene->node_count >= NODES_MAX) {
        stop(p, "there are more than %d elements", (int)NODES_MAX);
        return -1;
    }
    if (!ty_grow_array(scene->context, (void**)&scene->nodes, &scene->node_capacity, scene->node_count,
                       sizeof *scene->nodes)) {
        stop_memory(p);
        return -1;
    }
    const int32_t index = (int32_t)scene->node_count;
    ty_mitsuba_node node = {.tag = ty_copy_text(scene->context, tag),
                            .attributes = ty_alloc_array(scene->context, 1, 1, true),
                            .attribute_size = 1,
                            .first_child = -1,
                            .last_child = -1,
                            .next = -1,
                            .file = p->file,
                            .line = (int32_t)XML_GetCurrentLineNumber(p->expat)};
    scene->nodes[scene->node_count++] = node;
    if (node.tag == NULL || node.attributes == NULL) {
        stop_memory(p);
        return -1;
    }
    const int32_t parent = p->depth > 0 ? p->stack[p->depth - 1] : -1;
    if (parent < 0) return index;
    ty_mitsuba_node* above = &scene->nodes[parent];
    if (above->last_child >= 0)
        scene->nodes[above->last_child].next = index;
    else
        above->first_child = index;
    above->last_child = index;
    return index;
}

static void add_default(parser* p, const char* name, const char* value) {
    ty_mitsuba* scene = p->scene;
    for (size_t i = 0; i < scene->default_count; ++i)
        if (strcmp(scene->defaults[i].name, name) == 0) return; /* the first one counts */
    if (!ty_grow_array(scene->context, (void**)&scene->defaults, &scene->default_capacity, scene->default_count,
                       sizeof *scene->defaults)) {
        stop_memory(p);
        return;
    }
    const ty_mitsuba_default added = {ty_copy_text(scene->context, name), ty_copy_text(scene->context, value)};
    scene->defaults[scene->default_count++] = added;
    if (added.name == NULL || added.value == NULL) stop_memory(p);
}

static void add_folder(parser* p, const char* name) {
    ty_mitsuba* scene = p->scene;
    if (!ty_grow_array(scene->context, (void**)&scene->folders, &scene->folder_capacity, scene->folder_count,
                       sizeof *scene->folders)) {
        stop_memory(p);
        return;
    }
    scene->folders[scene->folder_count] = ty_copy_text(scene->context, name);
    if (scene->folders[scene->folder_count] == NULL) {
        stop_memory(p);
        return;
    }
    ++scene->folder_count;
}

static ty_result parse_text(parser* above, ty_mitsuba* scene, const char* name, const char* text, size_t size);

static void include(parser* p, int32_t node, const char* name) {
    uint8_t* bytes = NULL;
    size_t size = 0;
    if (p->includes >= INCLUDES_MAX) {
        stop(p, "files are included more than %d deep", (int)INCLUDES_MAX);
        return;
    }
    p->result = ty_mitsuba_read_file(p->scene, node, name, &bytes, &size);
    if (p->result == TY_OK && bytes != NULL) p->result = parse_text(p, p->scene, name, (const char*)bytes, size);
    if (bytes != NULL) ty_free_file(p->scene->context, bytes, size);
    if (p->result != TY_OK) XML_StopParser(p->expat, XML_FALSE);
}

/* Elements that act while they are read. */
static void act(parser* p, int32_t node) {
    const char *name = ty_mitsuba_attribute(p->scene, node, "name"),
               *value = ty_mitsuba_attribute(p->scene, node, "value"),
               *file = ty_mitsuba_attribute(p->scene, node, "filename");
    if (ty_mitsuba_is(p->scene, node, "default")) {
        if (name != NULL && value != NULL) add_default(p, name, value);
    } else if (ty_mitsuba_is(p->scene, node, "path")) {
        if (value != NULL) add_folder(p, value);
    } else if (ty_mitsuba_is(p->scene, node, "include")) {
        if (file != NULL)
            include(p, node, file);
        else
            stop(p, "include has no filename");
    }
}

static void XMLCALL start_element(void* user, const char* name, const char** attributes) {
    parser* p = user;
    if (p->result != TY_OK) return;
    if (p->depth >= NESTED_MAX - 1) {
        stop(p, "elements are nested too deep");
        return;
    }
    if (p->depth == 0 && strcmp(name, "scene") != 0) stop(p, "the document is \"%.60s\", not a scene", name);
    if (p->result != TY_OK) return;
    if (p->depth == 0 && p->includes > 0) { /* the elements of an included file become those of the scene */
        p->stack[p->depth++] = 0;
        return;
    }
    const int32_t node = add_node(p, name);
    if (node < 0) return;
    for (; attributes[0] != NULL && p->result == TY_OK; attributes += 2) {
        char value[VALUE_MAX];
        if (!substitute(p, attributes[1], value)) return;
        if (!append(p, &p->scene->nodes[node], attributes[0], value)) stop_memory(p);
    }
    p->stack[p->depth++] = node;
    if (p->result == TY_OK) act(p, node);
}

static void XMLCALL end_element(void* user, const char* name) {
    parser* p = user;
    (void)name;
    if (p->result == TY_OK && p->depth > 0) --p->depth;
}

/* Entities could be defined to be large. */
static void XMLCALL start_doctype(void* user, const char* name, const char* system, const char* public, int internal) {
    (void)system;
    (void)public;
    (void)internal;
    stop(user, "a document type, \"%.60s\", has no place in a scene", name);
}

static ty_result parse_text(parser* above, ty_mitsuba* scene, const char* name, const char* text, size_t size) {
    enum { PART = 1 << 24 };
    if (!ty_grow_array(scene->context, (void**)&scene->files, &scene->file_capacity, scene->file_count,
                       sizeof *scene->files))
        return TY_ERROR_MEMORY;
    scene->files[scene->file_count] = ty_copy_text(scene->context, name);
    if (scene->files[scene->file_count] == NULL) return TY_ERROR_MEMORY;
    parser p = {.scene = scene, .file = (int32_t)scene->file_count++, .expat = XML_ParserCreate(NULL)};
    if (p.expat == NULL) return ty_fail(scene->context, TY_ERROR_MEMORY, "not enough memory to read %s", name);
    p.includes = above != NULL ? above->includes + 1 : 0;
    XML_SetUserData(p.expat, &p);
    XML_SetElementHandler(p.expat, start_element, end_element);
    XML_SetStartDoctypeDeclHandler(p.expat, start_doctype);
    enum XML_Status status = XML_STATUS_OK;
    for (size_t at = 0; status == XML_STATUS_OK && at < size;) {
        const size_t part = size - at < PART ? size - at : PART;
        status = XML_Parse(p.expat, text + at, (int)part, at + part == size);
        at += part;
    }
    if (p.result == TY_OK && (status != XML_STATUS_OK || size == 0)) {
        const enum XML_Error error = XML_GetErrorCode(p.expat);
        p.result = ty_fail(scene->context, error == XML_ERROR_NO_MEMORY ? TY_ERROR_MEMORY : TY_ERROR_INPUT,
                           "%s:%lu: not XML: %s", name, (unsigned long)XML_GetCurrentLineNumber(p.expat),
                           size == 0 ? "the file is empty" : XML_ErrorString(error));
    }
    XML_ParserFree(p.expat);
    return p.result;
}

ty_result ty_mitsuba_parse(ty_mitsuba* scene, const char* text, size_t size) {
    return parse_text(NULL, scene, scene->conversion->input, text, size);
}

#else

ty_result ty_mitsuba_parse(ty_mitsuba* scene, const char* text, size_t size) {
    (void)text;
    (void)size;
    return ty_fail(scene->context, TY_ERROR_UNSUPPORTED, "%s: this build reads no XML, which takes Expat",
                   scene->conversion->input);
}

#endif
