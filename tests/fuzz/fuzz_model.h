/* The end of the fuzz targets that read models. */
#ifndef TY_TESTS_FUZZ_MODEL_H
#define TY_TESTS_FUZZ_MODEL_H

#include "../model_check.h"
#include "fuzz_target.h"

/* A model was read and is whole, or a message says why it was not; then everything is given back. */
static inline void fuzz_finish_model(ty_context* context, size_t* used, ty_result result, ty_model* model) {
    if ((result == TY_OK) != (ty_take_error(context)[0] == '\0')) abort();
    if (result == TY_OK && !model_is_whole(model)) abort();
    ty_model_free(model);
    fuzz_finish(context, used);
}

#endif
