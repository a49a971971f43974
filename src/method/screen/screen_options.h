/* Options of the method screen in scene files, which choose among the fields of ty_screen_def. */
#ifndef TY_SCREEN_SCREEN_OPTIONS_H
#define TY_SCREEN_SCREEN_OPTIONS_H

#include "option/option.h"

#include <tyndall/screen.h>

typedef enum ty_screen_variant_word {
    TY_SCREEN_WORD_SCATTER,
    TY_SCREEN_WORD_GATHER,
    TY_SCREEN_WORD_NAIVE,     /* ty_screen_naive_def */
    TY_SCREEN_WORD_PUBLISHED, /* ty_screen_published_def */
    TY_SCREEN_WORD_REFERENCE
} ty_screen_variant_word;

/* The source of light from outside the picture. */
typedef enum ty_screen_environment {
    TY_SCREEN_ENVIRONMENT_AROUND, /* mean radiance at the camera from all directions, without media */
    TY_SCREEN_ENVIRONMENT_LIGHTS, /* environment lights alone */
    TY_SCREEN_ENVIRONMENT_NONE
} ty_screen_environment;

typedef struct ty_screen_scene_def {
    uint32_t cookie, bytes;
    ty_screen_variant_word variant;
    ty_screen_spread spread;
    int32_t filter, levels;
    ty_screen_environment environment;
    bool balance;
} ty_screen_scene_def;

extern const ty_option_table ty_screen_options;
extern const char* const ty_screen_spreads[];

#endif
