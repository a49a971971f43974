/* Maps of infinite lights. */
#include "io/interchange/environment_map.h"
#include "base/context.h"
#include "io/interchange/pbrt/pbrt.h"

ty_result ty_pbrt_environment(ty_pbrt* reader, const char* location, const char* name, const ty_affine* light,
                              double* upper_illuminance, char** reference) {
    char *path = NULL, *unused = NULL;
    ty_image *image = NULL, *map = NULL;
    ty_result result = ty_conversion_find_file(reader->conversion, location, name, &path, &unused);
    ty_free_text(reader->context, unused);
    if (result != TY_OK || path == NULL) return result;
    result = ty_image_read(reader->context, path, &image);
    ty_free_text(reader->context, path);
    if (result == TY_OK)
        result = ty_convert_map(reader->context, image, TY_MAP_OCTAHEDRAL, light, upper_illuminance, &map);
    ty_image_destroy(image);
    if (result != TY_OK) return result;
    result = ty_conversion_write_exr(reader->conversion, map, reference);
    ty_image_destroy(map);
    return result;
}
