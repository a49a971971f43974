/* Arguments of the launches of TY_SCREEN_SCATTER on a device, and its programs. */
#ifndef TY_METHOD_SCREEN_DEVICE_LAUNCH_H
#define TY_METHOD_SCREEN_DEVICE_LAUNCH_H

#include "device/program.h"
#include "method/screen/scatter.k.h"

/* A level of the pyramid: planes of light, then of moments, one after another. */
typedef struct ty_screen_device_level {
    int32_t width, height;
    TY_GLOBAL float* planes;                  /* 6; level 0 has none */
    TY_GLOBAL const float* across;            /* TY_SCREEN_DOWN_WEIGHTS of each column of the next level */
    TY_GLOBAL const float* down;              /* of each row of the next level */
    ty_screen_down_fraction down_fraction[3]; /* passed to the next level, per channel */
} ty_screen_device_level;

/* Counts of one thread of screen_split. */
typedef struct ty_screen_device_counts {
    int32_t nonfinite_fixed, missing_depth, oversized; /* as in ty_screen_counts */
    float largest[3];
} ty_screen_device_counts;

/* All arrays are in the device's memory. */
typedef struct ty_screen_launch {
    ty_screen_params params;
    ty_screen_taps taps;
    float limit[3];
    int32_t threads;                           /* of screen_split, each with every threads-th pixel */
    TY_GLOBAL const float* image;              /* red, green, blue, distances */
    TY_GLOBAL float* out;                      /* red, green, blue */
    TY_GLOBAL float* passed;                   /* 6 planes of the level: light and moments passed to the next */
    TY_GLOBAL ty_screen_device_counts* counts; /* of each thread */
    ty_screen_device_level level, next;
} ty_screen_launch;

/* In their order: the pixels of level 0, by threads; the light passed on from texels of another level; texels of the
 * next level; texels of a level with the light of the next; pixels with that of level 1. */
extern const ty_program ty_program_screen_split, ty_program_screen_pass, ty_program_screen_down, ty_program_screen_up,
    ty_program_screen_finish;

#endif
