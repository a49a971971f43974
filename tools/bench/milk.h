/* A glass of milk by a fast method: times, and errors against path tracing. */
#ifndef TY_BENCH_MILK_H
#define TY_BENCH_MILK_H

#include "bench/bench.h"
#include "method/method.h"

/* Writes the object `glass_of_milk`. Errors: those of the method and of ty_path_render. */
ty_result bench_milk(const bench_session* bench, const ty_method* method);

#endif
