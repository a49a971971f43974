// Renders a cloud from C++: thin owners over the C API free everything, whichever way a function is left.
#include <tyndall/tyndall.h>

#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>

template <auto destroy>
struct destroyer {
    template <typename T>
    void operator()(T* object) const {
        destroy(object);
    }
};
template <typename T, auto destroy>
using owner = std::unique_ptr<T, destroyer<destroy>>;

using context_ptr = owner<ty_context, ty_context_destroy>;
using grid_ptr = owner<ty_grid, ty_grid_release>;
using scene_ptr = owner<ty_scene, ty_scene_destroy>;
using image_ptr = owner<ty_image, ty_image_destroy>;

static void check(ty_context* context, ty_result result) {
    if (result != TY_OK) throw std::runtime_error(std::string(ty_result_name(result)) + ": " + ty_take_error(context));
}

static context_ptr make_context() {
    const ty_context_def def = ty_default_context_def();
    ty_context* context = nullptr;
    check(nullptr, ty_context_create(&def, &context));
    return context_ptr(context);
}

static grid_ptr make_noise(ty_context* context) {
    const ty_noise_def def = ty_default_noise_def();
    ty_grid* grid = nullptr;
    check(context, ty_grid_create_noise(context, &def, &grid));
    return grid_ptr(grid);
}

// A cumulus of noise, 1 m across, under a sun.
static scene_ptr make_scene(ty_context* context) {
    ty_scene* created = nullptr;
    check(context, ty_scene_create(context, TY_AXIS_Y, &created));
    scene_ptr scene(created);
    const grid_ptr noise = make_noise(context);
    ty_medium_def cloud = ty_default_medium_def();
    cloud.bounds = TY_BOUNDS_BOX;
    cloud.density_grid = noise.get();
    for (int a = 0; a < 3; ++a) {
        cloud.box_min[a] = -0.5;
        cloud.box_max[a] = 0.5;
        cloud.sigma_s[a] = 25;
        cloud.g[a] = 0.6f;
    }
    const ty_light_def sun = ty_default_light_def();
    check(context, ty_scene_add_medium(scene.get(), &cloud));
    check(context, ty_scene_add_light(scene.get(), &sun));
    check(context, ty_scene_commit(scene.get()));
    return scene;
}

static image_ptr render(ty_context* context, const ty_scene* scene) {
    ty_path_def def = ty_default_path_def();
    def.spp = 4;
    def.width = 64;
    def.height = 48;
    ty_image* image = nullptr;
    check(context, ty_path_render(scene, &def, &image, nullptr));
    return image_ptr(image);
}

int main() {
    try {
        const context_ptr context = make_context();
        const image_ptr image = render(context.get(), make_scene(context.get()).get());
        check(context.get(), ty_image_write_exr(context.get(), image.get(), "06_cpp.exr"));
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
