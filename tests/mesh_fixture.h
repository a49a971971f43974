/* Setup and teardown of tests of mesh files: a context of two threads that keeps its warnings. */
#ifndef TY_TESTS_MESH_FIXTURE_H
#define TY_TESTS_MESH_FIXTURE_H

#include "mesh_maker.h"

static log_book book;
static ty_context* context;

static int start(void** state) {
    (void)state;
    context = logged_context(&book, 2);
    return 0;
}

static int stop(void** state) {
    (void)state;
    ty_context_destroy(context);
    return 0;
}

#endif
