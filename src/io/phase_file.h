/* Phase functions in text files. */
#ifndef TY_IO_PHASE_FILE_H
#define TY_IO_PHASE_FILE_H

#include <tyndall/io.h>

/* The cosine of an angle in degrees, exact at both ends. */
double ty_phase_cosine(double degrees);

#endif
