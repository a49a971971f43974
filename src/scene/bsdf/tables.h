/* The tables that the build makes (make_tables.c). */
#ifndef TY_SCENE_BSDF_TABLES_H
#define TY_SCENE_BSDF_TABLES_H

#include "scene/bsdf/tables.k.h"

extern const ty_bsdf_tables ty_bsdf_default_tables;

#endif
