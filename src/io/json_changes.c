/* Lists of the changes between two JSON documents. */
#include "base/context.h"
#include "io/json_edit.h"
#include "io/json_patch.h"
#include "io/json_text.h"

#include <stdio.h>
#include <string.h>

enum { PATH_SIZE = 512 };

typedef struct change_list {
    ty_context* context;
    char** items;
    size_t count, capacity;
    char path[PATH_SIZE];
} change_list;

static ty_result compare(change_list* list, const json_t* before, const json_t* after);

/* Adds "PATH=VALUE"; NULL: the value is removed. */
static ty_result add_change(change_list* list, const json_t* value) {
    ty_text text = {.context = list->context};
    ty_text_add_word(&text, list->path);
    ty_text_add_word(&text, "=");
    if (value != NULL)
        ty_text_add_compact(&text, value);
    else
        ty_text_add_word(&text, "null");
    char* item = ty_text_finish(&text);
    if (item == NULL) return TY_ERROR_MEMORY;
    if (!ty_grow_array(list->context, (void**)&list->items, &list->capacity, list->count, sizeof(char*))) {
        ty_free_text(list->context, item);
        return TY_ERROR_MEMORY;
    }
    list->items[list->count++] = item;
    return TY_OK;
}

/* Each appends a step to the path, and returns its length before. */
static size_t enter_member(change_list* list, const char* key) {
    const size_t length = strlen(list->path);
    snprintf(list->path + length, PATH_SIZE - length, "%s%s", length > 0 ? "." : "", key);
    return length;
}

static size_t enter_element(change_list* list, size_t index) {
    const size_t length = strlen(list->path);
    snprintf(list->path + length, PATH_SIZE - length, "[%zu]", index);
    return length;
}

static ty_result compare_members(change_list* list, const json_t* before, const json_t* after) {
    const char* key;
    json_t* member;
    ty_result result = TY_OK;
    json_object_foreach((json_t*)before, key, member) {
        if (json_object_get(after, key) != NULL) continue;
        const size_t length = enter_member(list, key);
        result = add_change(list, NULL);
        list->path[length] = '\0';
        if (result != TY_OK) return result;
    }
    json_object_foreach((json_t*)after, key, member) {
        const json_t* old = json_object_get(before, key);
        const size_t length = enter_member(list, key);
        result = old != NULL ? compare(list, old, member) : add_change(list, member);
        list->path[length] = '\0';
        if (result != TY_OK) return result;
    }
    return TY_OK;
}

/* True if an array has objects or arrays. */
static bool has_containers(const json_t* array) {
    for (size_t i = 0; i < json_array_size(array); ++i)
        if (json_is_object(json_array_get(array, i)) || json_is_array(json_array_get(array, i))) return true;
    return false;
}

/* Elements are changed, then removed or appended. */
static ty_result compare_elements(change_list* list, const json_t* before, const json_t* after) {
    const ty_json_alignment parts = ty_json_align(before, after);
    const size_t pairs = parts.before < parts.after ? parts.before : parts.after;
    if ((parts.after > parts.before && parts.end > 0) || !has_containers(before)) return add_change(list, after);
    ty_result result = TY_OK;
    for (size_t i = 0; i < pairs && result == TY_OK; ++i) {
        const size_t length = enter_element(list, parts.start + i);
        result = compare(list, json_array_get(before, parts.start + i), json_array_get(after, parts.start + i));
        list->path[length] = '\0';
    }
    for (size_t i = pairs; i < parts.before && result == TY_OK; ++i) {
        const size_t length = enter_element(list, parts.start + pairs);
        result = add_change(list, NULL);
        list->path[length] = '\0';
    }
    for (size_t i = pairs; i < parts.after && result == TY_OK; ++i) {
        const size_t length = enter_element(list, parts.start + i);
        result = add_change(list, json_array_get(after, parts.start + i));
        list->path[length] = '\0';
    }
    return result;
}

static ty_result compare(change_list* list, const json_t* before, const json_t* after) {
    if (json_equal(before, after)) return TY_OK;
    if (json_is_object(before) && json_is_object(after)) return compare_members(list, before, after);
    if (json_is_array(before) && json_is_array(after)) return compare_elements(list, before, after);
    return add_change(list, after);
}

ty_result ty_json_list_changes(ty_context* context, const json_t* before, const json_t* after, char*** out,
                               int32_t* count) {
    change_list list = {.context = context};
    ty_result result = compare(&list, before, after);
    char** exact = NULL;
    if (result == TY_OK) {
        exact = ty_alloc_array(context, list.count, sizeof(char*), false);
        if (exact == NULL) result = TY_ERROR_MEMORY;
    }
    for (size_t i = 0; i < list.count; ++i)
        if (exact != NULL)
            exact[i] = list.items[i];
        else
            ty_free_text(context, list.items[i]);
    ty_free_array(context, list.items, list.capacity, sizeof(char*));
    if (result != TY_OK) return result;
    *out = exact;
    *count = (int32_t)list.count;
    return TY_OK;
}

void ty_json_free_changes(ty_context* context, char** changes, int32_t count) {
    for (int32_t i = 0; i < count; ++i) ty_free_text(context, changes[i]);
    ty_free_array(context, changes, (size_t)count, sizeof(char*));
}
