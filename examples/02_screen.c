/* Fog over frames that the caller owns, as an engine has them: interleaved RGBA and depth, nothing allocated per frame.
 */
#include <tyndall/tyndall.h>

#include <stdio.h>
#include <stdlib.h>

enum { WIDTH = 640, HEIGHT = 360, FRAMES = 3 };

/* A lamp on a wall 10 m away, seen past a near post. */
static void draw(float* rgba, float* depth, int frame) {
    for (int y = 0; y < HEIGHT; ++y)
        for (int x = 0; x < WIDTH; ++x) {
            const int post = x > 200 && x < 240, dx = x - 300 - 20 * frame, dy = y - 120;
            const float light = post ? 0.02f : dx * dx + dy * dy < 64 ? 50.0f : 0.2f;
            float* pixel = rgba + 4 * (y * WIDTH + x);
            for (int c = 0; c < 3; ++c) pixel[c] = light;
            pixel[3] = 1;
            depth[y * WIDTH + x] = post ? 2.0f : 10.0f;
        }
}

/* In place: the planes of color are those of out. */
static ty_screen_image describe(float* rgba, const float* depth) {
    ty_screen_image image = ty_default_screen_image();
    image.width = WIDTH;
    image.height = HEIGHT;
    image.distance = depth;
    for (int c = 0; c < 3; ++c) image.color.data[c] = rgba + c;
    image.color.step = 4;
    image.color.row = 4 * WIDTH;
    image.out = image.color;
    image.distance_row = WIDTH;
    return image;
}

static ty_result run(ty_context* context, float* rgba, float* depth) {
    ty_screen_def def = ty_default_screen_def();
    ty_medium_def fog = ty_default_medium_def();
    ty_result result = ty_medium_parse(context, "fog:30", &fog);
    if (result != TY_OK) return result;
    for (int c = 0; c < 3; ++c) {
        def.sigma_s[c] = fog.sigma_s[c];
        def.sigma_a[c] = fog.sigma_a[c];
        def.g[c] = fog.g[c];
    }
    def.focal[0] = def.focal[1] = ty_screen_focal(HEIGHT, 50);
    def.distance_kind = TY_SCREEN_DISTANCE_AXIS; /* a depth buffer, made linear */

    const size_t size = ty_screen_workspace(context, &def, WIDTH, HEIGHT);
    void* workspace = aligned_alloc(64, (size + 63) / 64 * 64);
    if (workspace == NULL) return TY_ERROR_MEMORY;
    for (int frame = 0; frame < FRAMES && result == TY_OK; ++frame) {
        draw(rgba, depth, frame);
        const ty_screen_image image = describe(rgba, depth);
        ty_screen_stats stats = ty_default_screen_stats();
        result = ty_screen_apply(context, &def, &image, workspace, size, &stats);
        if (result == TY_OK)
            printf("frame %d: %.2f ms, %d levels, beside the lamp %.3f\n", frame, 1e3 * stats.seconds, stats.levels,
                   (double)rgba[4 * (120 * WIDTH + 320 + 20 * frame)]);
    }
    free(workspace);
    return result;
}

int main(void) {
    const ty_context_def def = ty_default_context_def();
    ty_context* context = NULL;
    if (ty_context_create(&def, &context) != TY_OK) return 1;
    float* rgba = malloc(sizeof(float) * 4 * WIDTH * HEIGHT);
    float* depth = malloc(sizeof(float) * WIDTH * HEIGHT);
    const ty_result result = rgba == NULL || depth == NULL ? TY_ERROR_MEMORY : run(context, rgba, depth);
    if (result != TY_OK) fprintf(stderr, "%s: %s\n", ty_result_name(result), ty_take_error(context));
    free(depth);
    free(rgba);
    ty_context_destroy(context);
    return result == TY_OK ? 0 : 1;
}
