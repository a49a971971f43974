/* TIFF stacks in two parts: tiff_text.c reads what ImageJ and OME write into the description, tiff.c the pages. */
#ifndef TY_IO_TIFF_STACK_H
#define TY_IO_TIFF_STACK_H

#include <stdbool.h>
#include <stdint.h>

typedef enum ty_stack_writer { TY_STACK_PLAIN, TY_STACK_IMAGEJ, TY_STACK_OME } ty_stack_writer;

/* Order of planes, and spacings of voxels. */
typedef struct ty_stack_layout {
    ty_stack_writer writer;
    int32_t slices, channels, times; /* planes are slices x channels x times */
    char order[4];                   /* of 'Z', 'C', 'T', fastest first */
    double spacing[3];               /* in `unit`; 0: not given. ImageJ: along z alone */
    char unit[32];
} ty_stack_layout;

/* Reads the description of the first page, which may be NULL. */
ty_stack_layout ty_stack_parse(const char* description);

#endif
