/* The NetCDF library, loaded at run time, and files of it. */
#include "io/volumes/netcdf/netcdf.h"

#include "base/context.h"
#include "io/file.h"

#if TYNDALL_NETCDF

#include "io/volumes/netcdf/calls.h"

#include <dlfcn.h>
#include <pthread.h>
#include <string.h>

/* The library has state of its own and no locks: one thread of the process is in it at a time. */
static pthread_mutex_t library_lock = PTHREAD_MUTEX_INITIALIZER;
static ty_netcdf_calls calls;
static bool loaded;

static const char* const names[] = {TYNDALL_NETCDF_LIBRARY, "libnetcdf.so.22", "libnetcdf.so.19", "libnetcdf.so.18",
                                    "libnetcdf.so"};

static bool find(void* handle, const char* name, void* function) {
    void* address = dlsym(handle, name);
    memcpy(function, &address, sizeof address);
    return address != NULL;
}

/* It stays loaded. */
static ty_result load(ty_context* context, const char* path) {
    void* handle = NULL;
    if (loaded) return TY_OK;
    for (size_t i = 0; i < sizeof names / sizeof names[0] && handle == NULL; ++i)
        handle = dlopen(names[i], RTLD_NOW | RTLD_LOCAL);
    if (handle == NULL)
        return ty_fail(context, TY_ERROR_UNSUPPORTED, "%s: NetCDF files need %s, which is not installed or cannot load",
                       path, names[0]);
    loaded = find(handle, "nc_open", &calls.open) && find(handle, "nc_close", &calls.close) &&
             find(handle, "nc_strerror", &calls.strerror) && find(handle, "nc_inq_nvars", &calls.inq_nvars) &&
             find(handle, "nc_inq_varid", &calls.inq_varid) && find(handle, "nc_inq_var", &calls.inq_var) &&
             find(handle, "nc_inq_dim", &calls.inq_dim) && find(handle, "nc_inq_att", &calls.inq_att) &&
             find(handle, "nc_get_att_text", &calls.get_att_text) &&
             find(handle, "nc_get_att_string", &calls.get_att_string) &&
             find(handle, "nc_free_string", &calls.free_string) &&
             find(handle, "nc_get_att_double", &calls.get_att_double) &&
             find(handle, "nc_get_vara_double", &calls.get_vara_double);
    if (loaded) return TY_OK;
    dlclose(handle);
    return ty_fail(context, TY_ERROR_UNSUPPORTED, "%s: the installed NetCDF library lacks functions that it needs",
                   path);
}

ty_result ty_netcdf_fail(const ty_netcdf_file* file, int status) {
    const ty_result result = status == NC_ENOMEM ? TY_ERROR_MEMORY : TY_ERROR_INPUT;
    return ty_fail(file->context, result, "%s: %s", file->path, calls.strerror(status));
}

/* The library takes names with a scheme for addresses, which those of a folder never are. */
static ty_result open_path(ty_netcdf_file* file) {
    char* path = ty_join_path(file->context, file->path[0] == '/' ? "" : ".", file->path);
    if (path == NULL) return TY_ERROR_MEMORY;
    const int status = calls.open(path, NC_NOWRITE, &file->id);
    ty_free_text(file->context, path);
    return status == NC_NOERR ? TY_OK : ty_netcdf_fail(file, status);
}

ty_result ty_netcdf_open(ty_context* context, const char* path, ty_netcdf_file* file) {
    FILE* stream = NULL;
    *file = (ty_netcdf_file){.context = context, .path = path, .calls = &calls};
    ty_result result = ty_open_file(context, path, &stream, &file->size);
    if (result != TY_OK) return result;
    fclose(stream);
    result = ty_netcdf_check_classic(file);
    if (result != TY_OK) return result;
    pthread_mutex_lock(&library_lock);
    result = load(context, path);
    if (result == TY_OK) result = open_path(file);
    if (result != TY_OK) pthread_mutex_unlock(&library_lock);
    return result;
}

void ty_netcdf_close(ty_netcdf_file* file) {
    calls.close(file->id);
    pthread_mutex_unlock(&library_lock);
}

#endif
