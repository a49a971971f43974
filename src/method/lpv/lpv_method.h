/* Sums of the times that a light propagation volume took. */
#ifndef TY_METHOD_LPV_LPV_METHOD_H
#define TY_METHOD_LPV_LPV_METHOD_H

#include <tyndall/lpv.h>

/* Maps of lights and the injection of their light; the propagation on the lattice; the picture. */
double ty_lpv_injection_seconds(const ty_lpv_stats* lpv);
double ty_lpv_propagation_seconds(const ty_lpv_stats* lpv);
double ty_lpv_image_seconds(const ty_lpv_stats* lpv);

/* ty_method.of_interiors. */
#define TY_LPV_OF_INTERIORS "solid dielectrics are opaque, and media in them are lit as without a surface"

#endif
