/* Wavefront OBJ files and their materials. */
#define _GNU_SOURCE
#include "mesh_fixture.h"

#include "io/meshes/obj.h"

#include <locale.h>
#include <png.h>

static ty_result read_text(const char* text, const char* folder, ty_model* model) {
    book = (log_book){0};
    return ty_read_obj(context, "made.obj", folder, (const uint8_t*)text, strlen(text), TY_MODEL_ALL, model);
}

static void read_well(const char* text, const char* folder, ty_model* model) {
    if (read_text(text, folder, model) != TY_OK) fail_msg("%s", ty_take_error(context));
    assert_true(model_is_whole(model));
}

static void assert_indices(const ty_model_mesh* mesh, const uint32_t* expected, size_t triangles) {
    assert_int_equal(mesh->triangle_count, triangles);
    for (size_t i = 0; i < 3 * triangles; ++i) assert_int_equal(mesh->indices[i], expected[i]);
}

/* Two triangles of a quad share two vertices; a third has a corner with other texture coordinates. */
static void corners_become_vertices(void** state) {
    (void)state;
    static const char text[] = "# a comment\r\n"
                               "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
                               "vt 0 0\nvt 1 0.25\nvt 1 1\nvt 0 1\nvn 0 0 2\n"
                               "o thing\ng some group\ns 1\n"
                               "f 1/1/1 2/2/1 3/3/1 4/4/1\n"
                               "f -4/3/-1 -3/2/-1 -2/3/-1\n";
    ty_model model;
    read_well(text, NULL, &model);
    assert_int_equal(model.mesh_count, 1);
    const ty_model_mesh* mesh = &model.meshes[0];
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3, 4, 1, 2};
    assert_indices(mesh, indices, 3);
    assert_int_equal(mesh->vertex_count, 5);
    static const float positions[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 0};
    static const float uv[] = {0, 1, 1, 0.75f, 1, 0, 0, 0, 1, 0}; /* row 0 of a texture is at v = 1 of the file */
    static const float normal[] = {0, 0, 1};
    assert_floats(mesh->positions, positions, 15);
    assert_floats(mesh->uv[0], uv, 10);
    for (int i = 0; i < 5; ++i) assert_floats(mesh->normals + 3 * i, normal, 3);
    assert_null(mesh->colors);
    assert_true(model.materials[mesh->material].def.albedo[0] == 0.5f);
    ty_model_free(&model);
}

static void all_forms_of_corners_are_read(void** state) {
    (void)state;
    static const char text[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.5\nvn 1 0 0\n"
                               "f 1 2 3\nf 1/1 2/1 3/1\nf 1//1 2//1 3//1\nf 1/ 2// 3\n";
    ty_model model;
    read_well(text, NULL, &model);
    assert_int_equal(model.mesh_count, 2); /* flat and smooth */
    assert_int_equal(model.meshes[0].triangle_count, 3);
    assert_null(model.meshes[0].normals);
    assert_int_equal(model.meshes[1].triangle_count, 1);
    assert_non_null(model.meshes[1].normals);
    assert_null(model.meshes[1].uv[0]);
    ty_model_free(&model);
}

static void colours_of_vertices_are_read(void** state) {
    (void)state;
    static const char text[] = "v 0 0 0 1 0.5 0\nv 1e0 0 0 0 2 0\nv 0 .1E+1 \\\n -0. 0 0 1\nv 5 5 5 1\nf 1 2 3 4\n";
    static const float colors[] = {1, 0.5f, 0, 1, 0, 1, 0, 1, 0, 0, 1, 1, 1, 1, 1, 1};
    ty_model model;
    read_well(text, NULL, &model);
    assert_floats(model.meshes[0].colors, colors, 16);
    assert_true(model.meshes[0].positions[7] == 1);
    assert_true(model.materials[0].def.albedo[1] == 1);
    ty_model_free(&model);
}

static void put_png(const char* path) {
    static const uint8_t rgba[] = {1, 2, 3, 255, 5, 6, 7, 255};
    uint8_t bytes[1024];
    png_image image = {.version = PNG_IMAGE_VERSION, .width = 2, .height = 1, .format = PNG_FORMAT_RGBA};
    png_alloc_size_t size = sizeof bytes;
    assert_int_equal(png_image_write_to_memory(&image, bytes, &size, 0, rgba, 0, NULL), 1);
    put_file(path, bytes, size);
}

static void materials_are_read(void** state) {
    (void)state;
    put_png("bricks and mortar.png");
    put_text("made of.mtl", "newmtl red wall\nKd 1 0.25 2\nKe 3\nNs 5\nillum 2\nd 0.5\n"
                            "newmtl bricks\nKd 0 0 0\nmap_Kd -s 1 1 1 -clamp on bricks and mortar.png\n"
                            "map_Ke .\\bricks and mortar.png\nTr 1\ndecal x.png\n"
                            "newmtl unused\nmap_Kd bricks and mortar.png\n");
    static const char text[] = "mtllib made of.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n"
                               "usemtl bricks\nf 1 2 3\nusemtl red wall\nf 1 2 3\nusemtl bricks\nf 3 2 1\n"
                               "usemtl nowhere\nf 1 3 2\nl 1 2\n";
    ty_model model;
    read_well(text, "", &model);
    assert_int_equal(model.material_count, 4);
    assert_int_equal(model.mesh_count, 3); /* none, red, bricks */
    assert_int_equal(model.meshes[0].material, 0);
    assert_int_equal(model.meshes[1].material, 1);
    assert_int_equal(model.meshes[2].material, 2);
    assert_int_equal(model.meshes[2].triangle_count, 2);
    static const float red[] = {1, 0.25f, 1}, glow[] = {3, 3, 3}, white[] = {1, 1, 1};
    assert_string_equal(model.materials[1].name, "red wall");
    assert_floats(model.materials[1].def.albedo, red, 3);
    assert_floats(model.materials[1].def.emission, glow, 3);
    assert_true(model.materials[1].def.alpha == 0.5f && model.materials[1].def.alpha_mode == TY_ALPHA_BLEND);
    assert_floats(model.materials[2].def.albedo, white, 3);
    assert_int_equal(model.materials[2].def.alpha_mode, TY_ALPHA_OPAQUE);
    assert_int_equal(model.texture_count, 3);
    assert_int_equal(model.textures[0].wrap[0], TY_WRAP_CLAMP);
    assert_int_equal(model.textures[1].wrap[0], TY_WRAP_REPEAT);
    const ty_model_image* image = &model.images[model.textures[model.materials[2].albedo_texture].image];
    assert_int_equal(image->width, 2);
    assert_int_equal(image->rgba8[4], 5);
    assert_int_equal(book.warnings, 3); /* decal, the line, the unknown material */
    ty_model_free(&model);
}

/* Materials of a diffuse colour alone, of Phong's keys and of those of newer writers. */
static void gloss_is_read(void** state) {
    (void)state;
    put_text("gloss.mtl", "newmtl diffuse\nKd 1 1 1\nNs 100\n"
                          "newmtl phong\nKd 1 1 1\nKs 0.5 0.25 0.5\nNs 6\nNi 1.25\n"
                          "newmtl metal\nKd 1 0.5 0\nPr 0.25\nPm 1\nNs 3\nKs 0 0 0\nPc 0.5\nPcr 2\n");
    static const char text[] = "mtllib gloss.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl metal\nf 1 2 3\n";
    ty_model model;
    read_well(text, "", &model);
    const ty_gloss_def *diffuse = &model.materials[1].def.gloss, *phong = &model.materials[2].def.gloss,
                       *metal = &model.materials[3].def.gloss;
    static const float color[] = {1, 0.5f, 1};
    assert_true(diffuse->specular == 0 && diffuse->metallic == 0);
    assert_floats(phong->specular_color, color, 3);
    assert_true(phong->specular == 1 && phong->ior == 1.25f);
    assert_true(fabs((double)phong->roughness - sqrt(0.5)) < 1e-6);
    assert_true(metal->metallic == 1 && metal->roughness == 0.25f && metal->specular == 0);
    assert_true(metal->clearcoat == 0.5f && metal->clearcoat_roughness == 1);
    ty_model_free(&model);
}

/* Reads an MTL text alone, with its maps; to be freed. */
static ty_model read_materials(const char* text) {
    put_text("own.mtl", text);
    ty_model model;
    read_well("mtllib own.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "", &model);
    return model;
}

/* Ks is relative to the reflection of ior 1.5, of mirrors it is the reflectance; an index of 1 says nothing. */
static void models_of_illumination_are_read(void** state) {
    (void)state;
    ty_model model = read_materials("newmtl dull\nKs 1 1 1\nillum 1\n"
                                    "newmtl plain\nillum 2\nNi 1\nKs 0.5\n"
                                    "newmtl mirror\nillum 5\nKd 0 0 0\nKs 0.5 0.25 0.125\nNi 1.5\n"
                                    "newmtl metal\nillum 3\nPm 1\nPr 0.5\nKs 0.5 0.5 0.5\n");
    const ty_gloss_def *dull = &model.materials[1].def.gloss, *plain = &model.materials[2].def.gloss,
                       *mirror = &model.materials[3].def.gloss, *metal = &model.materials[4].def.gloss;
    static const float reflectance[] = {12.5f, 6.25f, 3.125f}, white[] = {1, 1, 1};
    assert_true(dull->specular == 0 && dull->metallic == 0);
    assert_true(plain->specular == 1 && plain->ior == 1.5f);
    assert_floats(plain->specular_color, white, 3);
    assert_true(mirror->specular == 1);
    assert_floats(mirror->specular_color, reflectance, 3); /* times F0 = 0.04 */
    assert_true(metal->metallic == 1);
    assert_floats(metal->specular_color, white, 3);
    ty_model_free(&model);
}

static void glass_is_read(void** state) {
    (void)state;
    ty_model model = read_materials("newmtl glass\nillum 7\nNi 1.33\nKd 0.01 0.01 0.01\nTf 1 0.5 0.25\nd 0.1\nNs 900\n"
                                    "newmtl frosted\nTf 1\nPr 0.25\nillum 6\n"
                                    "newmtl filtered\nTf 0.5 0.5 0.5\nillum 2\nKd 1 1 1\n");
    const ty_material_def *glass = &model.materials[1].def, *frosted = &model.materials[2].def,
                          *filtered = &model.materials[3].def;
    static const float tint[] = {1, 0.5f, 0.25f};
    assert_true(glass->gloss.solid && glass->gloss.transmission == 1 && glass->gloss.ior == 1.33f);
    assert_true(glass->gloss.roughness == 0 && glass->alpha_mode == TY_ALPHA_OPAQUE);
    assert_floats(glass->albedo, tint, 3);
    assert_true(frosted->gloss.solid && frosted->gloss.roughness == 0.25f && frosted->gloss.ior == 1.5f);
    assert_true(!filtered->gloss.solid && filtered->gloss.transmission == 0 && filtered->albedo[0] == 1);
    ty_model_free(&model);
}

/* Tr is 1 - d, but a Tr of 1 alone is opaque. */
static void opacities_are_read(void** state) {
    (void)state;
    ty_model model = read_materials("newmtl a\nTr 0.25\nnewmtl b\nTr 0.25\nd 0.5\nnewmtl c\nTr 1\nnewmtl d\nTr 0\n"
                                    "newmtl e\nPs 0.5\nd 1\n");
    static const float alphas[] = {0.75f, 0.5f, 1, 1, 1}, sheen[] = {0.5f, 0.5f, 0.5f};
    for (size_t i = 0; i < 5; ++i) {
        assert_true(model.materials[i + 1].def.alpha == alphas[i]);
        assert_true((model.materials[i + 1].def.alpha_mode == TY_ALPHA_BLEND) == (alphas[i] < 1));
    }
    assert_floats(model.materials[5].def.gloss.sheen_color, sheen, 3);
    ty_model_free(&model);
}

/* A PNG of one texel. */
static void put_texel(const char* path, uint8_t red, uint8_t green, uint8_t blue, uint8_t alpha) {
    const uint8_t rgba[] = {red, green, blue, alpha};
    uint8_t bytes[1024];
    png_image image = {.version = PNG_IMAGE_VERSION, .width = 1, .height = 1, .format = PNG_FORMAT_RGBA};
    png_alloc_size_t size = sizeof bytes;
    assert_int_equal(png_image_write_to_memory(&image, bytes, &size, 0, rgba, 0, NULL), 1);
    put_file(path, bytes, size);
}

static const uint8_t* texels_of(const ty_model* model, int32_t texture) {
    assert_true(texture >= 0);
    return model->images[model->textures[texture].image].rgba8;
}

/* Opacity becomes the alpha of the base colour, roughness green and metallic blue of one texture. */
static void maps_of_one_number_are_joined(void** state) {
    (void)state;
    put_png("wide.png");
    put_texel("gray.png", 64, 64, 64, 255);
    put_texel("dark.png", 32, 32, 32, 255);
    put_texel("clear.png", 9, 9, 9, 128);
    ty_model model = read_materials("newmtl cut\nmap_Kd wide.png\nmap_d gray.png\n"
                                    "newmtl own\nmap_Kd clear.png\nmap_d clear.png\n"
                                    "newmtl alone\nmap_d gray.png\n"
                                    "newmtl metal\nPr 0.5\nmap_Pr gray.png\nmap_Pm dark.png\n"
                                    "newmtl rough\nmap_Pr gray.png\n"
                                    "newmtl same\nmap_Pm wide.png\nmap_Pr wide.png\n");
    static const uint8_t cut[] = {1, 2, 3, 64, 5, 6, 7, 64}, own[] = {9, 9, 9, 128}, alone[] = {255, 255, 255, 64},
                         metal[] = {255, 64, 32, 255}, rough[] = {255, 64, 255, 255};
    const ty_model_material* m = model.materials + 1;
    assert_memory_equal(texels_of(&model, m[0].albedo_texture), cut, sizeof cut);
    assert_memory_equal(texels_of(&model, m[1].albedo_texture), own, sizeof own);
    assert_memory_equal(texels_of(&model, m[2].albedo_texture), alone, sizeof alone);
    for (int i = 0; i < 3; ++i) {
        assert_int_equal(m[i].def.alpha_mode, TY_ALPHA_BLEND);
        assert_false(model.textures[m[i].albedo_texture].linear);
    }
    assert_memory_equal(texels_of(&model, m[3].gloss_textures[TY_GLOSS_METALLIC_ROUGHNESS]), metal, sizeof metal);
    assert_memory_equal(texels_of(&model, m[4].gloss_textures[TY_GLOSS_METALLIC_ROUGHNESS]), rough, sizeof rough);
    assert_int_equal(texels_of(&model, m[5].gloss_textures[TY_GLOSS_METALLIC_ROUGHNESS])[5], 6);
    assert_true(m[3].def.gloss.metallic == 1 && m[3].def.gloss.roughness == 0.5f && m[3].def.gloss.specular == 1);
    assert_true(m[4].def.gloss.metallic == 0 && m[4].def.gloss.roughness == 1 && m[4].def.gloss.specular == 1);
    assert_true(model.textures[m[3].gloss_textures[TY_GLOSS_METALLIC_ROUGHNESS]].linear);
    assert_int_equal(book.warnings, 0);
    ty_model_free(&model);
}

static void bumps_are_normals_or_left_out(void** state) {
    (void)state;
    put_texel("gray.png", 64, 64, 64, 255);
    put_texel("normal.png", 128, 128, 255, 255);
    put_texel("color.png", 9, 8, 7, 255);
    ty_model model = read_materials("newmtl heights\nbump gray.png\n"
                                    "newmtl normals\nmap_Bump -bm 0.5 normal.png\n"
                                    "newmtl both\nnorm normal.png\nbump -bm 1 gray.png\n"
                                    "newmtl colored\nKs 0 0 0\nmap_Ks color.png\nmap_Ps color.png\n");
    const ty_model_material* m = model.materials + 1;
    assert_int_equal(m[0].gloss_textures[TY_GLOSS_NORMAL], -1);
    assert_int_equal(texels_of(&model, m[1].gloss_textures[TY_GLOSS_NORMAL])[2], 255);
    assert_true(m[1].def.gloss.normal_scale == 0.5f);
    assert_int_equal(texels_of(&model, m[2].gloss_textures[TY_GLOSS_NORMAL])[0], 128);
    assert_false(model.textures[m[3].gloss_textures[TY_GLOSS_SPECULAR_COLOR]].linear);
    assert_true(m[3].gloss_textures[TY_GLOSS_SHEEN_COLOR] >= 0 && m[3].def.gloss.sheen_color[2] == 1);
    assert_true(m[3].def.gloss.specular == 1 && m[3].def.gloss.specular_color[1] == 1);
    assert_non_null(strstr(book.text, "made.obj: 2 maps of heights have no effect"));
    ty_model_free(&model);
}

/* v of the file points up: twice the map and a shift by (0.5, 0.25) of it. */
static void maps_are_scaled_and_moved(void** state) {
    (void)state;
    put_png("wide.png");
    ty_model model = read_materials("newmtl a\nmap_Kd -s 2 4 1 -o 0.5 0.25 0 wide.png\nnorm -s 3 3 wide.png\n");
    static const float map[] = {2, 0, 0.5f, 0, 4, -3.25f}, normals[] = {3, 0, 0, 0, 3, -2};
    assert_floats(model.materials[1].def.albedo_map, map, 6);
    assert_floats(model.materials[1].def.gloss.textures[TY_GLOSS_NORMAL].map, normals, 6);
    assert_int_equal(book.warnings, 0);
    ty_model_free(&model);
}

static void missing_materials_are_survived(void** state) {
    (void)state;
    ty_model model;
    read_well("mtllib gone.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n", "", &model);
    assert_int_equal(book.warnings, 2);
    assert_int_equal(model.meshes[0].material, 0);
    ty_model_free(&model);
}

static void numbers_do_not_depend_on_the_locale(void** state) {
    (void)state;
    if (setlocale(LC_ALL, "de_DE.UTF-8") == NULL && setlocale(LC_ALL, "fr_FR.UTF-8") == NULL) skip();
    ty_model model;
    const ty_result result = read_text("v 0.5 0 0\nv 1.25 0 0\nv 0 1 0\nf 1 2 3\n", NULL, &model);
    setlocale(LC_ALL, "C");
    assert_int_equal(result, TY_OK);
    assert_true(model.meshes[0].positions[0] == 0.5f && model.meshes[0].positions[3] == 1.25f);
    ty_model_free(&model);
}

static void references_may_lead_on_or_nowhere(void** state) {
    (void)state;
    static const char ahead[] = "v 0 0 0\nf 1 2 3\nv 1 0 0\nv 0 1 0\n";
    static const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    ty_model model;
    read_well(ahead, NULL, &model);
    assert_floats(model.meshes[0].positions, positions, 9);
    ty_model_free(&model);
    book = (log_book){0};
    read_well("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1//1 2//1 3/4/1\n", NULL, &model);
    assert_null(model.meshes[0].normals);
    assert_null(model.meshes[0].uv[0]);
    assert_non_null(strstr(book.text, "3 corners name normals or texture vertices that are not there"));
    ty_model_free(&model);
}

static void broken_files_are_refused(void** state) {
    (void)state;
    static const struct {
        const char *text, *message;
    } cases[] = {
        {"", "made.obj: there are no faces"},
        {"v 0 0 0\nv 1 0 0\n", "made.obj: there are no faces"},
        {"v 0 0\n", "made.obj:1: numbers are missing or damaged"},
        {"\nv 0 0 x\n", "made.obj:2: numbers are missing or damaged"},
        {"v 1 2 3,5\n", "made.obj:1: numbers are missing or damaged"},
        {"v 1 2 1e99\n", "made.obj:1: a number is not finite"},
        {"v 1 2 nan\n", "made.obj:1: a number is not finite"},
        {"vn 1 2\n", "made.obj:1: numbers are missing or damaged"},
        {"v 0 0 0\nf 1 2 3\n", "made.obj:2: there is no vertex 3, but 1"},
        {"v 0 0 0\nf 1 -2 1\n", "made.obj:2: there is no vertex -2, but 1 so far"},
        {"v 0 0 0\nf 0 1 1\n", "made.obj:2: there is no vertex 0"},
        {"v 0 0 0\nf 1 a 1\n", "made.obj:2: a face is damaged"},
        {"v 0 0 0\nf 1/1/1/1 1 1\n", "made.obj:2: a face is damaged"},
        {"v 0 0 0\nf 1 1x 1\n", "made.obj:2: a face is damaged"},
        {"v 0 0 0\nf 99999999999999999999 1 1\n", "made.obj:2: a face is damaged"},
        {"mtllib ../up.mtl\n", "made.obj:1: \"../up.mtl\" leads out of the file's folder"},
        {"mtllib /etc/passwd\n", "made.obj:1: \"/etc/passwd\" is not a path relative to the file"},
        {"mtllib\n", "made.obj:1: the name of a material file is damaged"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        ty_model model;
        assert_failed(context, read_text(cases[i].text, "", &model), TY_ERROR_INPUT, "made.obj", cases[i].message);
        ty_model_free(&model);
    }
}

static void broken_materials_are_refused(void** state) {
    (void)state;
    static const struct {
        const char *text, *message;
    } cases[] = {
        {"newmtl a\nKd 1 2\n", "made.mtl:2: a colour is not three numbers"},
        {"newmtl a\nKe 1 2 inf\n", "made.mtl:2: a colour is not finite"},
        {"newmtl a\nd\n", "made.mtl:2: a number is damaged"},
        {"newmtl a\nmap_Kd -clamp on\n", "made.mtl:2: the name of a map is damaged"},
        {"newmtl a\n\nmap_Kd ../x.png\n", "made.mtl:3: \"../x.png\" leads out"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        ty_model model = {.context = context};
        const ty_result result = ty_read_mtl(context, "made.mtl", "", cases[i].text, strlen(cases[i].text), &model);
        assert_failed(context, result, TY_ERROR_INPUT, "made.mtl", cases[i].message);
        ty_model_free(&model);
    }
    put_text("absent.mtl", "newmtl a\nmap_Kd absent.png\n");
    ty_model model;
    assert_failed(context, read_text("mtllib absent.mtl\n", "", &model), TY_ERROR_FILE, "absent.png", "No such file");
    ty_model_free(&model);
}

/* A grid of a million triangles: every vertex is found again by the four faces that share it. */
static void large_files_are_read(void** state) {
    (void)state;
    enum { SIDE = 708, LINE_SIZE = 64 };
    const size_t room = (size_t)(SIDE + 1) * (SIDE + 1) * LINE_SIZE + (size_t)SIDE * SIDE * LINE_SIZE;
    char* text = malloc(room);
    assert_non_null(text);
    size_t used = 0;
    for (int y = 0; y <= SIDE; ++y)
        for (int x = 0; x <= SIDE; ++x) used += (size_t)sprintf(text + used, "v %d.25 %d.5 -1.5e-3\n", x, y);
    for (int y = 0; y < SIDE; ++y)
        for (int x = 1; x <= SIDE; ++x) {
            const int a = y * (SIDE + 1) + x, b = a + SIDE + 1;
            used += (size_t)sprintf(text + used, "f %d %d %d %d\n", a, a + 1, b + 1, b);
        }
    struct timespec begin, end;
    clock_gettime(CLOCK_MONOTONIC, &begin);
    ty_model model;
    read_well(text, NULL, &model);
    clock_gettime(CLOCK_MONOTONIC, &end);
    printf("%.1f MB of OBJ in %.2f s\n", (double)used / 1e6,
           (double)(end.tv_sec - begin.tv_sec) + 1e-9 * (double)(end.tv_nsec - begin.tv_nsec));
    assert_int_equal(model.meshes[0].triangle_count, 2 * SIDE * SIDE);
    assert_int_equal(model.meshes[0].vertex_count, (SIDE + 1) * (SIDE + 1));
    ty_model_free(&model);
    free(text);
}

static ty_result read_and_free(ty_context* strict, void* user) {
    ty_model model;
    const char* text = user;
    const ty_result result =
        ty_read_obj(strict, "made.obj", NULL, (const uint8_t*)text, strlen(text), TY_MODEL_ALL, &model);
    ty_model_free(&model);
    return result;
}

static void short_memory_is_survived(void** state) {
    (void)state;
    static char text[] = "v 0 0 0 1 1 1\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\nf 1 2 3\n";
    strict_memory memory = {.limit = (size_t)1 << 30, .until_refusal = -1};
    ty_context* strict = strict_context(&memory);
    assert_true(check_short_memory(strict, &memory, read_and_free, text) > 5);
    ty_context_destroy(strict);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(corners_become_vertices),
        cmocka_unit_test(all_forms_of_corners_are_read),
        cmocka_unit_test(colours_of_vertices_are_read),
        cmocka_unit_test(materials_are_read),
        cmocka_unit_test(gloss_is_read),
        cmocka_unit_test(models_of_illumination_are_read),
        cmocka_unit_test(glass_is_read),
        cmocka_unit_test(opacities_are_read),
        cmocka_unit_test(maps_of_one_number_are_joined),
        cmocka_unit_test(bumps_are_normals_or_left_out),
        cmocka_unit_test(maps_are_scaled_and_moved),
        cmocka_unit_test(missing_materials_are_survived),
        cmocka_unit_test(numbers_do_not_depend_on_the_locale),
        cmocka_unit_test(references_may_lead_on_or_nowhere),
        cmocka_unit_test(broken_files_are_refused),
        cmocka_unit_test(broken_materials_are_refused),
        cmocka_unit_test(large_files_are_read),
        cmocka_unit_test(short_memory_is_survived),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
