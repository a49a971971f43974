/* Denoising by Intel Open Image Denoise, where it is installed: its C API, loaded at run time. The declarations are
 * ours, by the library's public documentation, of functions that versions 1 and 2 have in common. */
#include "base/context.h"
#include "image/denoise/job.h"

#include <dlfcn.h>
#include <string.h>

/* Values of the API: OIDN_DEVICE_TYPE_CPU, which reads the caller's memory, OIDN_FORMAT_FLOAT3 and OIDN_ERROR_NONE. */
enum { DEVICE_CPU = 1, FORMAT_FLOAT3 = 3, NO_ERROR = 0 };

typedef struct oidn_library {
    void* handle;
    void* (*new_device)(int type);
    void (*set_device_int)(void* device, const char* name, int value);
    void (*commit_device)(void* device);
    void (*release_device)(void* device);
    int (*get_error)(void* device, const char** message);
    void* (*new_filter)(void* device, const char* type);
    void (*set_image)(void* filter, const char* name, void* pixels, int format, size_t width, size_t height,
                      size_t offset, size_t pixel_stride, size_t row_stride);
    void (*set_bool)(void* filter, const char* name, bool value);
    void (*commit_filter)(void* filter);
    void (*execute)(void* filter);
    void (*release_filter)(void* filter);
} oidn_library;

static const char* const files[] = {
#ifdef __APPLE__
    "libOpenImageDenoise.2.dylib", "libOpenImageDenoise.1.dylib", "libOpenImageDenoise.dylib"
#else
    "libOpenImageDenoise.so.2", "libOpenImageDenoise.so.1", "libOpenImageDenoise.so.0", "libOpenImageDenoise.so"
#endif
};

/* Stores the address of a function, by its name in version 2 or that in version 1. */
static bool find(void* handle, const char* name, const char* formerly, void* function) {
    void* address = dlsym(handle, name);
    if (address == NULL && formerly != NULL) address = dlsym(handle, formerly);
    memcpy(function, &address, sizeof address);
    return address != NULL;
}

static ty_result load(ty_context* context, oidn_library* out) {
    for (size_t i = 0; i < sizeof files / sizeof files[0] && out->handle == NULL; ++i)
        out->handle = dlopen(files[i], RTLD_NOW | RTLD_LOCAL);
    if (out->handle == NULL)
        return ty_fail(context, TY_ERROR_UNSUPPORTED,
                       "denoise.denoiser: Open Image Denoise is not installed: %s is not among the loader's libraries "
                       "(LD_LIBRARY_PATH names further folders)",
                       files[0]);
    void* handle = out->handle;
    const bool whole = find(handle, "oidnNewDevice", NULL, &out->new_device) &&
                       find(handle, "oidnSetDeviceInt", "oidnSetDevice1i", &out->set_device_int) &&
                       find(handle, "oidnCommitDevice", NULL, &out->commit_device) &&
                       find(handle, "oidnReleaseDevice", NULL, &out->release_device) &&
                       find(handle, "oidnGetDeviceError", NULL, &out->get_error) &&
                       find(handle, "oidnNewFilter", NULL, &out->new_filter) &&
                       find(handle, "oidnSetSharedFilterImage", NULL, &out->set_image) &&
                       find(handle, "oidnSetFilterBool", "oidnSetFilter1b", &out->set_bool) &&
                       find(handle, "oidnCommitFilter", NULL, &out->commit_filter) &&
                       find(handle, "oidnExecuteFilter", NULL, &out->execute) &&
                       find(handle, "oidnReleaseFilter", NULL, &out->release_filter);
    if (whole) return TY_OK;
    dlclose(handle);
    out->handle = NULL;
    return ty_fail(context, TY_ERROR_UNSUPPORTED,
                   "denoise.denoiser: the installed Open Image Denoise lacks functions of its versions 1 and 2");
}

ty_result ty_denoiser_is_available(ty_context* context, ty_denoiser denoiser) {
    oidn_library library = {.handle = NULL};
    if (denoiser == TY_DENOISER_REGRESSION) return TY_OK;
    if (denoiser != TY_DENOISER_OIDN)
        return ty_fail(context, TY_ERROR_ARGUMENT, "denoise.denoiser: %d is none of ty_denoiser", (int)denoiser);
    const ty_result result = load(context, &library);
    if (result == TY_OK) dlclose(library.handle);
    return result;
}

/* ---- images ---- */

/* Pixels of three floats: light, albedo, normal, and the result. */
enum { LIGHT = 0, ALBEDO = 1, NORMAL = 2, RESULT = 3, IMAGES = 4 };

typedef struct oidn_run {
    ty_denoise_job* job;
    oidn_library library;
    void* device;
    float* pixels[IMAGES];
    bool has_albedo, has_normal;
} oidn_run;

static size_t values(const oidn_run* run) {
    return 3 * run->job->pixels;
}

static void interleave(const oidn_run* run, const float* plane, int c, int image) {
    for (size_t i = 0; i < run->job->pixels; ++i) run->pixels[image][3 * i + (size_t)c] += plane[i];
}

/* Adds one half of three channels to an image; false if the image at hand lacks them. */
static bool add_half(const oidn_run* run, const char* const names[3], int half, int image) {
    ty_denoise_job* job = run->job;
    float* const halves[2] = {job->scratch[1], job->scratch[2]};
    for (int c = 0; c < 3; ++c)
        if (ty_denoise_find(job, names[c], false) == NULL) return false;
    for (int c = 0; c < 3; ++c) {
        ty_denoise_split(job, ty_denoise_find(job, names[c], false), ty_denoise_find(job, names[c], true), halves);
        interleave(run, halves[half], c, image);
    }
    return true;
}

/* The albedo of surfaces, and that of media before them, by the fraction of the light that meets them. */
static void load_half(oidn_run* run, int half) {
    static const char* const light[3] = {"R", "G", "B"};
    static const char* const surface[3] = {"surface_albedo.R", "surface_albedo.G", "surface_albedo.B"};
    static const char* const medium[3] = {"albedo.R", "albedo.G", "albedo.B"};
    static const char* const normal[3] = {"normal.X", "normal.Y", "normal.Z"};
    for (int i = 0; i < IMAGES; ++i) memset(run->pixels[i], 0, values(run) * sizeof(float));
    add_half(run, light, half, LIGHT);
    run->has_albedo = add_half(run, surface, half, ALBEDO) && add_half(run, medium, half, ALBEDO);
    run->has_normal = run->has_albedo && add_half(run, normal, half, NORMAL);
}

static void take_half(const oidn_run* run, int half) {
    ty_denoise_job* job = run->job;
    for (int c = 0; c < 3; ++c)
        for (size_t i = 0; i < job->pixels; ++i) {
            const float value = run->pixels[RESULT][3 * i + (size_t)c];
            job->raw[half][c][i] = run->pixels[LIGHT][3 * i + (size_t)c];
            job->denoised[half][c][i] = value >= 0 && value < 1e15f ? value : 0;
        }
}

/* ---- filter ---- */

static void set_image(const oidn_run* run, void* filter, const char* name, int image) {
    run->library.set_image(filter, name, run->pixels[image], FORMAT_FLOAT3, (size_t)run->job->width,
                           (size_t)run->job->height, 0, 0, 0);
}

static ty_result check(const oidn_run* run) {
    const char* message = NULL;
    if (run->library.get_error(run->device, &message) == NO_ERROR) return TY_OK;
    return ty_fail(run->job->context, TY_ERROR_INTERNAL, "Open Image Denoise: %s",
                   message != NULL ? message : "it failed without a message");
}

static ty_result filter_half(oidn_run* run, int half) {
    const oidn_library* library = &run->library;
    load_half(run, half);
    void* filter = library->new_filter(run->device, "RT");
    if (filter == NULL) return check(run) != TY_OK ? TY_ERROR_INTERNAL : TY_ERROR_MEMORY;
    set_image(run, filter, "color", LIGHT);
    if (run->has_albedo) set_image(run, filter, "albedo", ALBEDO);
    if (run->has_normal) set_image(run, filter, "normal", NORMAL);
    set_image(run, filter, "output", RESULT);
    library->set_bool(filter, "hdr", true);
    library->commit_filter(filter);
    library->execute(filter);
    const ty_result result = check(run);
    library->release_filter(filter);
    if (result == TY_OK) take_half(run, half);
    return result;
}

static ty_result filter_halves(oidn_run* run) {
    ty_denoise_job* job = run->job;
    ty_result result = TY_OK;
    for (int half = 0; half < 2 && result == TY_OK; ++half) {
        result = filter_half(run, half);
        if (result == TY_OK) result = ty_part_show(&job->progress, "denoise", 0.5 * (half + 1));
    }
    job->stats.parts = 1;
    job->stats.features = (run->has_albedo ? 3 : 0) + (run->has_normal ? 3 : 0);
    return result;
}

ty_result ty_denoise_by_oidn(ty_denoise_job* job) {
    oidn_run run = {.job = job};
    ty_result result = load(job->context, &run.library);
    for (int i = 0; i < IMAGES && result == TY_OK; ++i) {
        run.pixels[i] = ty_alloc_array(job->context, values(&run), sizeof(float), true);
        if (run.pixels[i] == NULL) result = TY_ERROR_MEMORY;
    }
    if (result == TY_OK && (run.device = run.library.new_device(DEVICE_CPU)) == NULL)
        result = ty_fail(job->context, TY_ERROR_UNSUPPORTED, "Open Image Denoise: this processor is not supported");
    if (result == TY_OK) {
        run.library.set_device_int(run.device, "numThreads", ty_context_threads(job->context));
        run.library.commit_device(run.device);
        result = check(&run);
    }
    if (result == TY_OK) result = filter_halves(&run);
    if (run.device != NULL) run.library.release_device(run.device);
    for (int i = 0; i < IMAGES; ++i) ty_free_array(job->context, run.pixels[i], values(&run), sizeof(float));
    if (run.library.handle != NULL) dlclose(run.library.handle);
    return result;
}
