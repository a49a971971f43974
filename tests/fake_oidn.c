/* A stand-in for Open Image Denoise with the functions that Tyndall uses, for test_oidn.sh: a mean over 5 x 5 pixels.
 * It fails with a message where it was not set up as it should be, or FAKE_OIDN_FAILS is set. OIDN_1: the names of
 * version 1.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

/* Its prototypes are those that Tyndall has of its own. */
#pragma GCC diagnostic ignored "-Wmissing-prototypes"

#ifdef OIDN_1
#define oidnSetDeviceInt oidnSetDevice1i
#define oidnSetFilterBool oidnSetFilter1b
#endif

static struct {
    float *color, *albedo, *normal, *output;
    long width, height;
    bool device, threads, hdr, filter;
    const char* error;
} fake;

void* oidnNewDevice(int type) {
    memset(&fake, 0, sizeof fake);
    if (type != 1) fake.error = "not a device on the processor";
    return &fake;
}

void oidnSetDeviceInt(void* device, const char* name, int value) {
    fake.threads = device == &fake && strcmp(name, "numThreads") == 0 && value > 0;
}

void oidnCommitDevice(void* device) {
    fake.device = device == &fake;
}

void oidnReleaseDevice(void* device) {
    if (device != &fake || fake.filter) abort();
}

int oidnGetDeviceError(void* device, const char** message) {
    *message = device == &fake ? fake.error : "no device";
    fake.error = NULL;
    return *message != NULL ? 2 : 0;
}

void* oidnNewFilter(void* device, const char* type) {
    fake.filter = device == &fake && fake.device && fake.threads && strcmp(type, "RT") == 0;
    return fake.filter ? &fake : NULL;
}

void oidnSetSharedFilterImage(void* filter, const char* name, void* pixels, int format, size_t width, size_t height,
                              size_t offset, size_t pixel_stride, size_t row_stride) {
    if (filter != &fake || format != 3 || offset + pixel_stride + row_stride != 0) fake.error = "not of packed floats";
    fake.width = (long)width;
    fake.height = (long)height;
    if (strcmp(name, "color") == 0) fake.color = pixels;
    if (strcmp(name, "albedo") == 0) fake.albedo = pixels;
    if (strcmp(name, "normal") == 0) fake.normal = pixels;
    if (strcmp(name, "output") == 0) fake.output = pixels;
}

void oidnSetFilterBool(void* filter, const char* name, bool value) {
    fake.hdr = filter == &fake && strcmp(name, "hdr") == 0 && value;
}

void oidnCommitFilter(void* filter) {
    if (filter != &fake || fake.color == NULL || fake.output == NULL || !fake.hdr) fake.error = "not set up";
    if (fake.normal != NULL && fake.albedo == NULL) fake.error = "normals without an albedo";
    if (getenv("FAKE_OIDN_FAILS") != NULL) fake.error = "failure on demand";
}

static float mean(long x, long y, int c) {
    float sum = 0;
    int count = 0;
    for (long py = y - 2; py <= y + 2; ++py)
        for (long px = x - 2; px <= x + 2; ++px) {
            if (px < 0 || py < 0 || px >= fake.width || py >= fake.height) continue;
            sum += fake.color[3 * (py * fake.width + px) + c];
            ++count;
        }
    return sum / (float)count;
}

void oidnExecuteFilter(void* filter) {
    if (filter != &fake || fake.error != NULL) return;
    for (long y = 0; y < fake.height; ++y)
        for (long x = 0; x < fake.width; ++x)
            for (int c = 0; c < 3; ++c) fake.output[3 * (y * fake.width + x) + c] = mean(x, y, c);
}

void oidnReleaseFilter(void* filter) {
    if (filter != &fake) abort();
    fake.filter = false;
    fake.color = fake.albedo = fake.normal = fake.output = NULL;
    fake.hdr = false;
}
