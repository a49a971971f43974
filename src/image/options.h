/* Image options common to the methods: their descriptors and one validation. */
#ifndef TY_IMAGE_OPTIONS_H
#define TY_IMAGE_OPTIONS_H

#include "option/option.h"

#include <tyndall/image.h>
#include <tyndall/scene.h>

/* Descriptors of the fields that defs of several methods have under the same name. */
#define TY_OPTION_ENVIRONMENT_BEAMS(def)                                                                               \
    {                                                                                                                  \
        TY_OPTION_FIELD(def, environment_beams),                                                                       \
            .type = TY_OPTION_INT, .min = 1, .max = 65536, .preset = 64,                                               \
            .doc = "Number of directions that each environment light is divided into."                                 \
    }
#define TY_OPTION_SURFACE_POINTS(def)                                                                                  \
    {                                                                                                                  \
        TY_OPTION_FIELD(def, surface_points),                                                                          \
            .type = TY_OPTION_INT, .min = 1, .max = 65536, .preset = 16,                                               \
            .doc = "Number of points that each area light and glowing sphere is replaced by."                          \
    }
#define TY_OPTION_SPP(def)                                                                                             \
    {                                                                                                                  \
        TY_OPTION_FIELD(def, spp),                                                                                     \
            .type = TY_OPTION_INT, .min = 1, .max = 64, .preset = 1,                                                   \
            .doc = "Number of camera rays per pixel; a single ray goes through the pixel's center."                    \
    }
#define TY_OPTION_STEP(def, of)                                                                                        \
    {                                                                                                                  \
        TY_OPTION_FIELD(def, step), .type = TY_OPTION_DOUBLE, .min = 0.05, .max = 8, .preset = 1, .unit = of,          \
                                    .doc = "Length of the steps in which rays of the camera march through the media."  \
    }
#define TY_OPTION_INTERIOR_RESOLUTION(def)                                                                             \
    {                                                                                                                  \
        TY_OPTION_FIELD(def, interior_resolution),                                                                     \
            .type = TY_OPTION_INT, .min = 4, .max = 256, .preset = TY_AUTO, .flags = TY_OPTION_AUTO, .unit = "cells",  \
            .doc = "Cells along the longest side of each medium that fills a solid dielectric, such as milk in a "     \
                   "glass; auto is as many as it is transport mean free paths long, 32 to 48, and 32 from 96 on."      \
    }
#define TY_OPTION_RAY_SPACING(def)                                                                                     \
    {                                                                                                                  \
        TY_OPTION_FIELD(def, ray_spacing),                                                                             \
            .type = TY_OPTION_INT, .min = 1, .max = 8, .preset = 1, .unit = "pixels",                                  \
            .doc = "Distance between rays of the camera; above 1, pixels between them are interpolated, except at "    \
                   "edges."                                                                                            \
    }

typedef struct ty_image_options {
    int32_t width, height; /* pixels; both 0: the camera's */
    int32_t spp;
    uint64_t seed;
    double step;   /* as ty_march_def.step */
    uint32_t aovs; /* TY_AOV_... */
} ty_image_options;

/* Validates channels and resolution. method: prefix of field names in messages; known: all TY_AOV_... supported by the
 * method. Errors: TY_ERROR_ARGUMENT.
 */
ty_result ty_check_image(ty_context* context, const char* method, const ty_image_options* options, uint32_t known);
/* Validates width and height only. */
ty_result ty_check_resolution(ty_context* context, const char* method, int32_t width, int32_t height);
/* Resolution of the image: that of the camera where the options leave it unset. */
void ty_image_resolution(const ty_scene* scene, int32_t width, int32_t height, int32_t size[2]);

#endif
