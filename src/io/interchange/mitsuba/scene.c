#include "io/interchange/mitsuba/mitsuba.h"
#include "base/context.h"
ty_result ty_read_mitsuba(ty_conversion* conversion, const char* text, size_t size) {
    (void)text; (void)size;
    return ty_fail(conversion->context, TY_ERROR_INPUT, "not yet");
}
