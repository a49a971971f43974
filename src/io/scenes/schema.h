/* Validates JSON against a JSON Schema (the subset of draft 2020-12 listed below) and describes the first issue in one
 * sentence.
 * Supported: type (one name), const, enum, minimum, maximum, exclusiveMinimum, exclusiveMaximum, multipleOf
 * (integers), minLength, items, minItems, maxItems, properties, additionalProperties (false), required, anyOf,
 * oneOf, $defs, $ref ("#/$defs/NAME", beside annotations only). Annotations: $schema, title, description, default.
 * The branches of anyOf and oneOf must be mutually exclusive: one branch is selected, by JSON type, by the value of
 * a shared "const" key, then by the number of known keys, and only that branch is validated. */
#ifndef TY_IO_SCHEMA_H
#define TY_IO_SCHEMA_H

#include "io/json_locate.h"

#include <jansson.h>

typedef struct ty_schema_issue {
    ty_json_path path; /* keys belong to the value and the schema */
    char text[512];    /* "1.2 is outside (-1, 1)" */
} ty_schema_issue;

/* False, with the first issue, if value does not conform to the schema. */
bool ty_schema_check(const json_t* schema, const json_t* value, ty_schema_issue* issue);

#endif
