/* Images of textures as scene files take them: PNG, JPEG or WebP in sRGB, or numbers as they are. */
#ifndef TY_IO_INTERCHANGE_TEXTURE_FILES_H
#define TY_IO_INTERCHANGE_TEXTURE_FILES_H

#include "io/interchange/conversion.h"

/* The rule by which an image's samples become those of the scene file. */
typedef struct ty_texture_reading {
    bool linear;     /* the samples of 8-bit files are not in sRGB */
    bool inverted;   /* 1 - sample */
    double exponent; /* of numbers: their power; 0: colours */
} ty_texture_reading;

/* The name of the image in the scene file: the file itself where it serves, else a new one. *reference is NULL, with a
 * note, if it cannot be read. */
ty_result ty_convert_texture(ty_conversion* conversion, const char* location, const char* name,
                             const ty_texture_reading* reading, char** reference);

#endif
