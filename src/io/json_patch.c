#include "io/json_patch.h"

#include "base/context.h"
#include "io/json_text.h"

#include <string.h>

enum { LONGEST_LINE = 100, INDENT_MAX = 64 };

/* Part of the text. */
typedef struct span {
    const char* at;
    size_t length;
} span;

/* Form of a text. */
typedef struct json_style {
    span newline;
    span indent; /* of one level; empty: all is on one line */
    span colon, comma;
    span object, array; /* after the opening bracket on one line */
} json_style;

typedef struct patch {
    const char *at, *end;
    json_style style;
    ty_text out;
} patch;

/* A container while its items are written. */
typedef struct container {
    span first_lead, lead;            /* space before the first item, and before the one read last */
    span trail;                       /* space after the item written last */
    size_t read, written;             /* number of items */
    bool broken_object, broken_array; /* the last of its kind goes over several lines */
} container;

static span literal(const char* text) {
    return (span){text, strlen(text)};
}

static void add(patch* p, span text) {
    ty_text_add(&p->out, text.at, text.length);
}

static bool has_newline(span text) {
    return text.length > 0 && memchr(text.at, '\n', text.length) != NULL;
}

/* ---- reading ---- */

static bool is_space(char c) {
    return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

static span take_space(patch* p) {
    const char* start = p->at;
    while (p->at < p->end && is_space(*p->at)) ++p->at;
    return (span){start, (size_t)(p->at - start)};
}

static span take_string(patch* p) {
    const char* start = p->at++;
    while (p->at < p->end && *p->at != '"') p->at += *p->at == '\\' ? 2 : 1;
    ++p->at;
    return (span){start, (size_t)(p->at - start)};
}

/* A value without the space behind it. */
static span take_value(patch* p) {
    const char* start = p->at;
    size_t depth = 0;
    do {
        const char c = *p->at;
        if (c == '"') {
            take_string(p);
            continue;
        }
        if (depth == 0 && (c == ',' || c == '}' || c == ']' || is_space(c))) break;
        depth += c == '{' || c == '[';
        depth -= c == '}' || c == ']';
        ++p->at;
        if (depth == 0 && (c == '}' || c == ']')) break;
    } while (p->at < p->end);
    return (span){start, (size_t)(p->at - start)};
}

/* The colon with the spaces around it. */
static span take_colon(patch* p) {
    const char* start = p->at;
    take_space(p);
    ++p->at;
    take_space(p);
    return (span){start, (size_t)(p->at - start)};
}

/* ---- style ---- */

/* The spaces after a character that stands at `at`; false at the end of a line or before a closing bracket. */
static bool spaces_after(const patch* p, const char* at, span* out) {
    const char* next = at + 1;
    while (next < p->end && (*next == ' ' || *next == '\t')) ++next;
    if (next >= p->end || *next == '\n' || *next == '\r' || *next == '}' || *next == ']') return false;
    *out = (span){at + 1, (size_t)(next - at - 1)};
    return true;
}

/* The line end of the text, and the indentation of the line after the first bracket. */
static void find_indent(patch* p) {
    patch start = *p;
    take_space(&start);
    ++start.at;
    const span lead = take_space(&start);
    if (!has_newline(lead)) return;
    const char* newline = memchr(lead.at, '\n', lead.length);
    const bool returns = newline > lead.at && newline[-1] == '\r';
    p->style.newline = literal(returns ? "\r\n" : "\n");
    const char* line = lead.at + lead.length;
    while (line[-1] != '\n') --line;
    p->style.indent = (span){line, (size_t)(lead.at + lead.length - line)};
}

static void find_style(patch* p) {
    bool comma = false, object = false, array = false;
    p->style = (json_style){.colon = {NULL, 0}};
    find_indent(p);
    patch scan = *p;
    while (scan.at < scan.end) {
        const char c = *scan.at;
        if (c == '"') {
            take_string(&scan);
            const char* after = scan.at;
            take_space(&scan);
            if (scan.at < scan.end && *scan.at == ':' && p->style.colon.at == NULL) {
                scan.at = after;
                p->style.colon = take_colon(&scan);
            }
            continue;
        }
        if (c == ',' && !comma) comma = spaces_after(p, scan.at, &p->style.comma);
        if (c == '{' && !object) object = spaces_after(p, scan.at, &p->style.object);
        if (c == '[' && !array) array = spaces_after(p, scan.at, &p->style.array);
        ++scan.at;
    }
    if (p->style.colon.at == NULL || has_newline(p->style.colon)) p->style.colon = literal(": ");
    const bool spaced = p->style.colon.length > 1;
    if (!comma) p->style.comma = literal(spaced ? " " : "");
    if (!object) p->style.object = literal(spaced ? " " : "");
}

/* ---- writing new values ---- */

static void write_line(ty_text* out, const json_style* style, const json_t* value);

static void write_key(ty_text* out, const json_style* style, const char* key) {
    json_t* string = json_string(key);
    if (string == NULL) out->failed = true;
    if (string != NULL) ty_text_add_scalar(out, string);
    json_decref(string);
    ty_text_add(out, style->colon.at, style->colon.length);
}

static void write_item_line(ty_text* out, const json_style* style, size_t i) {
    if (i == 0) return;
    ty_text_add_word(out, ",");
    ty_text_add(out, style->comma.at, style->comma.length);
}

static void write_object_line(ty_text* out, const json_style* style, const json_t* object) {
    const char* key;
    json_t* member;
    size_t i = 0;
    ty_text_add_word(out, "{");
    if (json_object_size(object) > 0) ty_text_add(out, style->object.at, style->object.length);
    json_object_foreach((json_t*)object, key, member) {
        write_item_line(out, style, i++);
        write_key(out, style, key);
        write_line(out, style, member);
    }
    if (i > 0) ty_text_add(out, style->object.at, style->object.length);
    ty_text_add_word(out, "}");
}

/* A value on one line. */
static void write_line(ty_text* out, const json_style* style, const json_t* value) {
    if (json_is_object(value)) {
        write_object_line(out, style, value);
    } else if (json_is_array(value)) {
        const size_t count = json_array_size(value);
        ty_text_add_word(out, "[");
        if (count > 0) ty_text_add(out, style->array.at, style->array.length);
        for (size_t i = 0; i < count; ++i) {
            write_item_line(out, style, i);
            write_line(out, style, json_array_get(value, i));
        }
        if (count > 0) ty_text_add(out, style->array.at, style->array.length);
        ty_text_add_word(out, "]");
    } else {
        ty_text_add_scalar(out, value);
    }
}

/* True if a value on one line has a reasonable length, or cannot be broken. */
static bool fits(const patch* p, const json_t* value, size_t indent) {
    if (p->style.indent.length == 0) return true;
    if ((!json_is_object(value) && !json_is_array(value)) || json_object_size(value) + json_array_size(value) == 0)
        return true;
    ty_text line = {.context = p->out.context};
    write_line(&line, &p->style, value);
    const bool fits = !line.failed && line.length + indent <= LONGEST_LINE;
    ty_free_array(line.context, line.at, line.capacity, 1);
    return fits;
}

static void write_value(patch* p, const json_t* value, span indent, bool broken);

static void start_line(patch* p, span indent, size_t levels) {
    add(p, p->style.newline);
    add(p, indent);
    for (size_t i = 0; i < levels; ++i) add(p, p->style.indent);
}

/* An item of a broken container, on a line of its own, one level below it. */
static void write_item(patch* p, const char* key, const json_t* value, span indent, size_t i) {
    char below[INDENT_MAX];
    size_t length = 0;
    const span parts[] = {indent, p->style.indent};
    for (int k = 0; k < 2; ++k)
        for (size_t c = 0; c < parts[k].length && length < sizeof below; ++c) below[length++] = parts[k].at[c];
    if (i > 0) add(p, literal(","));
    start_line(p, indent, 1);
    if (key != NULL) write_key(&p->out, &p->style, key);
    write_value(p, value, (span){below, length}, false);
}

/* indent: that of the line on which the value begins. broken: containers go over several lines if the text has any. */
static void write_value(patch* p, const json_t* value, span indent, bool broken) {
    const size_t count = json_object_size(value) + json_array_size(value);
    const bool lines = broken && p->style.indent.length > 0 && count > 0;
    if (!lines && fits(p, value, indent.length)) {
        write_line(&p->out, &p->style, value);
        return;
    }
    const char* key;
    json_t* member;
    size_t i = 0;
    add(p, literal(json_is_object(value) ? "{" : "["));
    json_object_foreach((json_t*)value, key, member) write_item(p, key, member, indent, i++);
    for (; i < json_array_size(value); ++i) write_item(p, NULL, json_array_get(value, i), indent, i);
    start_line(p, indent, 0);
    add(p, literal(json_is_object(value) ? "}" : "]"));
}

/* ---- changes ---- */

static void write_changed(patch* p, const json_t* before, const json_t* after, span indent);

/* Indentation of the line that a space leads to; `around` if it leads to none. */
static span indent_after(span lead, span around) {
    const char* start = lead.at + lead.length;
    if (!has_newline(lead)) return around;
    while (start[-1] != '\n') --start;
    return (span){start, (size_t)(lead.at + lead.length - start)};
}

/* Reads the space before an item. */
static void read_lead(patch* p, container* c) {
    c->lead = take_space(p);
    if (c->read++ == 0) c->first_lead = c->lead;
}

/* Reads the space behind an item, and a comma. */
static span read_trail(patch* p) {
    const span trail = take_space(p);
    if (p->at < p->end && *p->at == ',') ++p->at;
    return trail;
}

static void begin_item(patch* p, container* c, span lead) {
    if (c->written++ == 0) {
        add(p, c->first_lead);
        return;
    }
    add(p, c->trail);
    add(p, literal(","));
    add(p, lead);
    c->trail = (span){NULL, 0};
}

/* The space before an item that is inserted. */
static span inserted_lead(const patch* p, const container* c) {
    if (c->read > 1 || has_newline(c->first_lead)) return c->lead;
    return p->style.comma;
}

static void insert_item(patch* p, container* c, const char* key, const json_t* value, span indent) {
    const span lead = inserted_lead(p, c);
    begin_item(p, c, lead);
    if (key != NULL) write_key(&p->out, &p->style, key);
    write_value(p, value, indent_after(c->written == 1 ? c->first_lead : lead, indent),
                json_is_object(value) ? c->broken_object : c->broken_array);
}

/* Writes the item that comes next, changed, and reads the space behind it. */
static void keep_item(patch* p, container* c, const json_t* before, const json_t* after, span indent) {
    const char* start = p->at;
    write_changed(p, before, after, indent_after(c->lead, indent));
    const bool broken = has_newline((span){start, (size_t)(p->at - start)});
    if (json_is_object(before)) c->broken_object = broken;
    if (json_is_array(before)) c->broken_array = broken;
    c->trail = read_trail(p);
}

/* closing: the space before the bracket in the old text. */
static void end_container(patch* p, const container* c, span closing, const char* bracket) {
    if (c->written > 0) add(p, closing);
    add(p, literal(bracket));
}

static json_t* member_of(const json_t* object, span token) {
    json_t* string = json_loadb(token.at, token.length, JSON_DECODE_ANY, NULL);
    json_t* member = string != NULL ? json_object_get(object, json_string_value(string)) : NULL;
    json_decref(string);
    return member;
}

static void write_object(patch* p, const json_t* before, const json_t* after, span indent) {
    container c = {.read = 0};
    span closing = {NULL, 0};
    add(p, literal("{"));
    ++p->at;
    for (size_t i = 0; i < json_object_size(before); ++i) {
        read_lead(p, &c);
        const span key = take_string(p), colon = take_colon(p);
        const json_t *old = member_of(before, key), *new = member_of(after, key);
        if (new == NULL) {
            take_value(p);
            closing = read_trail(p);
            continue;
        }
        begin_item(p, &c, c.lead);
        add(p, key);
        add(p, colon);
        keep_item(p, &c, old, new, indent);
        closing = c.trail;
    }
    if (c.read == 0) take_space(p);
    ++p->at;
    if (c.read > 0 && c.trail.at == closing.at) c.trail = (span){NULL, 0};
    if (c.read == 0 && json_object_size(after) > 0) closing = c.first_lead = p->style.object;
    const char* name;
    json_t* member;
    json_object_foreach((json_t*)after, name, member) {
        if (json_object_get(before, name) == NULL) insert_item(p, &c, name, member, indent);
    }
    end_container(p, &c, closing, "}");
}

ty_json_alignment ty_json_align(const json_t* before, const json_t* after) {
    const size_t m = json_array_size(before), n = json_array_size(after), min = m < n ? m : n;
    ty_json_alignment found = {.start = 0};
    while (found.start < min && json_equal(json_array_get(before, found.start), json_array_get(after, found.start)))
        ++found.start;
    while (found.end < min - found.start &&
           json_equal(json_array_get(before, m - 1 - found.end), json_array_get(after, n - 1 - found.end)))
        ++found.end;
    found.before = m - found.start - found.end;
    found.after = n - found.start - found.end;
    return found;
}

/* The element of `after` for the i-th of `before`; NULL: it is removed. */
static json_t* partner_of(const ty_json_alignment* aligned, const json_t* after, size_t i) {
    const size_t start = aligned->start;
    if (i >= start + aligned->before) return json_array_get(after, i - aligned->before + aligned->after);
    return i < start + aligned->after ? json_array_get(after, i) : NULL;
}

/* Elements that `before` has no partners for, which stand before the equal ones at the end. */
static void insert_elements(patch* p, container* c, const ty_json_alignment* aligned, const json_t* after,
                            span indent) {
    for (size_t i = aligned->before; i < aligned->after; ++i)
        insert_item(p, c, NULL, json_array_get(after, aligned->start + i), indent);
}

static void write_array(patch* p, const json_t* before, const json_t* after, span indent) {
    const ty_json_alignment aligned = ty_json_align(before, after);
    container c = {.read = 0};
    span closing = {NULL, 0};
    add(p, literal("["));
    ++p->at;
    for (size_t i = 0; i < json_array_size(before); ++i) {
        const json_t* new = partner_of(&aligned, after, i);
        read_lead(p, &c);
        if (i == aligned.start + aligned.before) insert_elements(p, &c, &aligned, after, indent);
        if (new == NULL) {
            take_value(p);
            closing = read_trail(p);
            continue;
        }
        begin_item(p, &c, c.read > 1 ? c.lead : inserted_lead(p, &c));
        keep_item(p, &c, json_array_get(before, i), new, indent);
        closing = c.trail;
    }
    if (c.read == 0) take_space(p);
    ++p->at;
    if (c.read > 0 && c.trail.at == closing.at) c.trail = (span){NULL, 0};
    if (c.read == 0 && json_array_size(after) > 0) closing = c.first_lead = p->style.array;
    if (aligned.end == 0) insert_elements(p, &c, &aligned, after, indent);
    end_container(p, &c, closing, "]");
}

/* Writes `after` for `before`, the value that comes next. */
static void write_changed(patch* p, const json_t* before, const json_t* after, span indent) {
    if (json_is_object(before) && json_is_object(after) && !json_equal(before, after)) {
        write_object(p, before, after, indent);
    } else if (json_is_array(before) && json_is_array(after) && !json_equal(before, after)) {
        write_array(p, before, after, indent);
    } else {
        const span old = take_value(p);
        if (json_equal(before, after))
            add(p, old);
        else
            write_value(p, after, indent, has_newline(old));
    }
}

char* ty_json_patch(ty_context* context, const char* text, size_t length, const json_t* before, const json_t* after) {
    static const char mark[] = "\xef\xbb\xbf"; /* UTF-8 byte order mark */
    patch p = {.at = text, .end = text + length, .out = {.context = context}};
    if (length >= 3 && memcmp(text, mark, 3) == 0) {
        add(&p, literal(mark));
        p.at += 3;
    }
    find_style(&p);
    add(&p, take_space(&p));
    write_changed(&p, before, after, (span){NULL, 0});
    add(&p, (span){p.at, (size_t)(p.end - p.at)});
    return ty_text_finish(&p.out);
}
