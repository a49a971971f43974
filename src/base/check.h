/* Argument checks shared by defs; each fails with TY_ERROR_ARGUMENT and names the field and its range. */
#ifndef TY_BASE_CHECK_H
#define TY_BASE_CHECK_H

#include <tyndall/scene.h>

/* Largest accepted colour or coefficient: larger ones overflow in single precision. */
#define TY_COLOR_MAX 1e15

ty_result ty_check_point(ty_context* context, const char* field, const double point[3]);
/* Finite and not zero. */
ty_result ty_check_direction(ty_context* context, const char* field, const double direction[3]);
/* Rays as the radiance functions of all methods take them: count of a point and a direction of any length, 6 numbers
 * each; radiance: the output, which must be there. */
ty_result ty_check_rays(ty_context* context, const double* rays, int64_t count, const double* radiance);
ty_result ty_check_affine(ty_context* context, const char* field, const ty_affine* affine);
/* Each channel finite, in [low, high]. */
ty_result ty_check_rgb(ty_context* context, const char* field, const float rgb[3], double low, double high);
ty_result ty_check_number(ty_context* context, const char* field, double value, double low, double high);
/* Edges that span an area. */
ty_result ty_check_edges(ty_context* context, const char* field, const double u[3], const double v[3]);

#endif
