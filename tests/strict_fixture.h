/* Setup and teardown of tests of readers and writers: a context whose memory is counted, in a folder that holds no
 * temporary files of a run that was killed. */
#ifndef TY_TESTS_STRICT_FIXTURE_H
#define TY_TESTS_STRICT_FIXTURE_H

#include "files.h"

static strict_memory memory;
static ty_context* context;

static int start(void** state) {
    (void)state;
    memory = (strict_memory){.limit = (size_t)1 << 30, .until_refusal = -1};
    context = strict_context(&memory);
    remove_temporary_files();
    return 0;
}

static int stop(void** state) {
    (void)state;
    ty_context_destroy(context);
    return memory.used == 0 ? 0 : -1;
}

#endif
