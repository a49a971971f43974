/* Descriptors of options: one table per def holds the name, type, range, default and documentation of its fields.
 * Defaults, range checks, the keys of scene files, their JSON Schema, shell completion and the tables of the manual are
 * generated from these tables. */
#ifndef TY_OPTION_OPTION_H
#define TY_OPTION_OPTION_H

#include <tyndall/base.h>

typedef enum ty_option_type {
    TY_OPTION_INT,    /* int32_t or uint32_t */
    TY_OPTION_DOUBLE, /* double */
    TY_OPTION_FLOAT,  /* float */
    TY_OPTION_BOOL,   /* bool */
    TY_OPTION_WORD    /* an enum or uint32_t, written as one of `words` */
} ty_option_type;

enum {
    TY_OPTION_AUTO = 1,     /* TY_AUTO is allowed: the method chooses */
    TY_OPTION_OPEN_MIN = 2, /* the range excludes min */
    TY_OPTION_OPEN_MAX = 4, /* the range excludes max */
    TY_OPTION_OPEN = 6,     /* the range excludes both ends */
    TY_OPTION_OR_ZERO = 8,  /* 0 is allowed beside the range and means none */
    TY_OPTION_BITS = 16, /* TY_OPTION_WORD: flags; words name some combinations of the bits of max, and all combinations
                            are allowed */
    TY_OPTION_CALLS_ONLY = 32 /* a field of the def without a key in scene files */
};

typedef struct ty_option {
    const char* name;
    const char* formerly;     /* name in earlier versions; NULL: unchanged */
    const char* unit;         /* "m", "cells"; NULL: dimensionless */
    const char* doc;          /* one sentence */
    const char* const* words; /* TY_OPTION_WORD: ends with NULL */
    const uint32_t* values;   /* TY_OPTION_WORD: the value of each word; NULL: 0, 1, 2 ... */
    double min, max;          /* of numbers; an infinite max leaves the range open */
    double preset;            /* the default; of words its value */
    double multiple;          /* numbers must be multiples of this; 0: any number */
    size_t offset, size;      /* offset of the field in the def, bytes */
    ty_option_type type;
    int32_t count;  /* elements of an array, which share range and default; 0: a single value */
    uint32_t flags; /* TY_OPTION_... */
} ty_option;

/* The name and the offset of a field. */
#define TY_OPTION_FIELD(def, field) TY_OPTION_KEY(def, field, #field)
/* The same for a field whose key in files is another word. */
#define TY_OPTION_KEY(def, field, key) .name = (key), .offset = offsetof(def, field), .size = sizeof(((def*)0)->field)

/* The options of one def. Fields without an option begin as zero. */
typedef struct ty_option_table {
    const char* name;             /* "dom": prefix of messages and of keys in scene files */
    const char* default_function; /* "ty_default_dom_def" */
    size_t bytes;                 /* size of the def */
    const ty_option* options;
    int32_t count;
} ty_option_table;

/* A method's options as an initialiser: TY_OPTION_TABLE("dom", ty_dom_def, "ty_default_dom_def", options). */
#define TY_OPTION_TABLE(name, def, default_function, options)                                                          \
    { name, default_function, sizeof(def), options, (int32_t)(sizeof(options) / sizeof(options)[0]) }

enum { TY_OPTION_TEXT_SIZE = 96 };

/* The option of a name, or NULL. */
const ty_option* ty_option_find(const ty_option_table* table, const char* name);
/* True if a caller's def, which can be of an older version, has the field. */
bool ty_option_fits(const ty_option* option, const void* def);
/* Formats a value in the syntax of scene files: "96", "auto", "diffusion", "true". */
void ty_option_text(const ty_option* option, double value, char text[TY_OPTION_TEXT_SIZE]);
/* The value of a field of a def; of arrays the first element. */
double ty_option_value(const ty_option* option, const void* def);
/* The word of an option's value, or NULL. */
const char* ty_option_word(const ty_option* option, uint32_t value);

/* Fills in a caller's def of `bytes` with all defaults, cookie and size. */
void ty_options_init(const ty_option_table* table, void* def, size_t bytes);
/* Lowers an int field to a bound, from "auto" too. */
static inline void ty_lower_option(int32_t* field, int32_t bound) {
    if (*field == TY_AUTO || *field > bound) *field = bound;
}

/* Copies a caller's def, which can be of an older and smaller version, over the library's defaults, and checks all
 * ranges. own has table->bytes. Errors: TY_ERROR_ARGUMENT. */
ty_result ty_options_take(ty_context* context, const ty_option_table* table, const void* def, void* own);
/* Sets the field of an option from text in the syntax of scene files, after a check of its range. Errors:
 * TY_ERROR_ARGUMENT. */
ty_result ty_options_set(ty_context* context, const ty_option_table* table, void* def, const char* key,
                         const char* value);

/* The name and the options of the index-th method, NULL past the last. Defined by the registry of methods, a layer
 * above; several methods can share a table. */
const ty_option_table* ty_method_options_at(int32_t index, const char** method);

#endif
