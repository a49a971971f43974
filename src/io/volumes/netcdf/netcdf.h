/* NetCDF files: library.c loads the library, classic.c finds files that are cut short, axes.c finds the axes of a
 * variable and the placement of its values, values.c reads values and their units, droplets.c makes extinction of
 * liquid water, slabs.c makes grids, and netcdf.c chooses among variables. */
#ifndef TY_IO_NETCDF_H
#define TY_IO_NETCDF_H

#include "grid/grid.h"

#include <tyndall/io.h>

enum { TY_NETCDF_NAME_SIZE = 257, TY_NETCDF_DIMENSIONS_MAX = 8 };

typedef struct ty_netcdf_calls ty_netcdf_calls;

typedef struct ty_netcdf_file {
    ty_context* context;
    const char* path;
    uint64_t size; /* bytes */
    const ty_netcdf_calls* calls;
    int id;
    bool quiet; /* what is wrong with coordinates is no error, and has no message */
} ty_netcdf_file;

/* Cells along an axis of space. */
typedef struct ty_netcdf_axis {
    int dimension; /* index among the variable's */
    size_t length;
    bool placed, even, descending;
    double* edges; /* length + 1, ascending, m or the file's own units; NULL: not placed */
} ty_netcdf_axis;

/* A variable of three axes of space, and one of times, or of anything else, at most. */
typedef struct ty_netcdf_variable {
    int id, type, dimension_count;
    char name[TY_NETCDF_NAME_SIZE];
    int dimensions[TY_NETCDF_DIMENSIONS_MAX];
    size_t lengths[TY_NETCDF_DIMENSIONS_MAX];
    ty_netcdf_axis axes[3];
    int times; /* index of the dimension of components, or -1 */
} ty_netcdf_variable;

/* Opens and closes a file; between both no other thread calls the library. ty_netcdf_close must follow success. */
ty_result ty_netcdf_open(ty_context* context, const char* path, ty_netcdf_file* file);
void ty_netcdf_close(ty_netcdf_file* file);
ty_result ty_netcdf_fail(const ty_netcdf_file* file, int status);

/* Refuses a classic file that is shorter than its header says. */
ty_result ty_netcdf_check_classic(const ty_netcdf_file* file);

/* Name, type and dimensions. */
ty_result ty_netcdf_describe(const ty_netcdf_file* file, int id, ty_netcdf_variable* variable);
/* Finds which dimension is which axis; false if the variable is not a volume of numbers. */
bool ty_netcdf_find_axes(const ty_netcdf_file* file, ty_netcdf_variable* variable);
/* Finds the edges of cells; ty_netcdf_release must follow, whatever the result. */
ty_result ty_netcdf_place(const ty_netcdf_file* file, ty_netcdf_variable* variable, double meters_per_unit);
void ty_netcdf_release(const ty_netcdf_file* file, ty_netcdf_variable* variable);

/* The text of an attribute, cut to the size; "" without one. id: -1 for the file's own. */
void ty_netcdf_text(const ty_netcdf_file* file, int id, const char* attribute, char* text, size_t size);
/* Factor from a length's units to m; 0 for units that are none of a length. */
double ty_netcdf_length_unit(const char* units);
/* Factor of a content of liquid water to kg m^-3, or to mass per mass of air if *ratio is set; of a radius to
 * micrometres; of a density to kg m^-3. 0 for other units. Without units: g m^-3, micrometres, kg m^-3. */
double ty_netcdf_water_unit(const char* units, bool* ratio);
double ty_netcdf_radius_unit(const char* units);
double ty_netcdf_density_unit(const char* units);

/* Reads the values of a variable at one time, in the file's order, from ty_alloc_array; missing ones are 0. Of the
 * dimension `along` only `length` from `first` on are read; -1: all. */
ty_result ty_netcdf_load(const ty_netcdf_file* file, const ty_netcdf_variable* variable, int32_t time, int along,
                         size_t first, size_t length, float** out, size_t* count);

/* Values of a variable on some of another one's dimensions, slab by slab along its z; or one value everywhere. */
typedef struct ty_netcdf_companion {
    bool given; /* false: `constant` */
    ty_netcdf_variable variable;
    int32_t time;
    int along;     /* its dimension that is the other's z, where slabs of it lie in one piece; -1: it is read at once */
    float* values; /* that were read last */
    size_t count, strides[3], first; /* first: along the other's z */
    double constant, unit;
} ty_netcdf_companion;

/* Sets time, strides and `along` of a companion by its variable, for another one's axes; fails if it has more. */
ty_result ty_netcdf_aim(const ty_netcdf_file* file, const ty_netcdf_variable* of, int32_t time,
                        ty_netcdf_companion* companion);
/* Reads the values from `first` on along z, in the file's order, unless they were read at once before. */
ty_result ty_netcdf_load_companion(const ty_netcdf_file* file, ty_netcdf_companion* c, size_t first, size_t length);
/* Value at a place in the file's order, within the slab that was read. */
double ty_netcdf_companion_value(const ty_netcdf_companion* c, const size_t at[3]);
void ty_netcdf_release_companion(const ty_netcdf_file* file, ty_netcdf_companion* c);

typedef struct ty_netcdf_droplets {
    ty_netcdf_companion radius, air;
    double water_unit;
    bool ratio, counting; /* counting: false: the sums stay */
    int64_t without_radius;
    double sum, sum_radius; /* of extinction, and of its product with the radius */
} ty_netcdf_droplets;

/* Finds what the droplets of a variable of liquid water take; ty_netcdf_release_droplets must follow, whatever the
 * result. */
ty_result ty_netcdf_open_droplets(const ty_netcdf_file* file, const ty_volume_def* def, const ty_netcdf_variable* water,
                                  ty_netcdf_droplets* out);
void ty_netcdf_release_droplets(const ty_netcdf_file* file, ty_netcdf_droplets* droplets);
/* Extinction coefficient, 1/m, at a place in the file's order, of a value of the variable of water. */
double ty_netcdf_extinction(ty_netcdf_droplets* d, double water, const size_t at[3]);

/* The grid of a variable, or of its droplets' extinction; never more than slabs of it are in memory where the file has
 * z in front of x and y, and of a part no others are read. */
ty_result ty_netcdf_make_grid(const ty_netcdf_file* file, const ty_netcdf_variable* variable, int32_t time,
                              ty_netcdf_droplets* droplets, const ty_grid_plan* plan, ty_grid** out);

/* As ty_volume_read_droplets and so on. */
ty_result ty_netcdf_read(ty_context* context, const char* path, const ty_volume_def* def, double* radius,
                         ty_grid** out);
ty_result ty_netcdf_components(ty_context* context, const char* path, const ty_volume_def* def, int32_t* out);
ty_result ty_netcdf_list(ty_context* context, const char* path, ty_vdb_entry* entries, int32_t capacity,
                         int32_t* count);

#endif
