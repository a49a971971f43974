#ifndef TY_IO_INTERCHANGE_MITSUBA_H
#define TY_IO_INTERCHANGE_MITSUBA_H
#include "io/interchange/conversion.h"
ty_result ty_read_mitsuba(ty_conversion* conversion, const char* text, size_t size);
#endif
