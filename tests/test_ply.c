/* PLY files: text and binary of both byte orders. */
#define _GNU_SOURCE
#include "mesh_fixture.h"

static ty_result read_bytes(const void* bytes, size_t size, ty_model* model) {
    return ty_read_ply(context, "made.ply", bytes, size, TY_MODEL_ALL, model);
}

static void read_well(const void* bytes, size_t size, ty_model* model) {
    if (read_bytes(bytes, size, model) != TY_OK) fail_msg("%s", ty_take_error(context));
    assert_true(model_is_whole(model));
    assert_int_equal(model->mesh_count, 1);
    assert_int_equal(model->instance_count, 1);
}

static const char ascii[] = "ply\nformat ascii 1.0\ncomment made\nobj_info here\n"
                            "element vertex 5\nproperty float x\nproperty double y\nproperty int z\n"
                            "property float quality\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
                            "element edge 2\nproperty list uchar int ends\nproperty float length\n"
                            "element face 3\nproperty uchar flags\nproperty list uchar int vertex_indices\n"
                            "element last 1\nproperty int a\nend_header\n"
                            "0 0 0 1 255 188 0\n1e0 0 0 1 0 0 0\n1 1 0 1 0 0 0\n-0.5 1 0 1 0 0 0\n0 .5 0 1 0 0 0\n"
                            "2 0 1 0.5\n0 7\n"
                            "9 3 0 1 2\n9 5 0 1 2 3 4\n9 2 0 1\n5";

static void text_is_read(void** state) {
    (void)state;
    ty_model model;
    read_well(ascii, strlen(ascii), &model);
    const ty_model_mesh* mesh = &model.meshes[0];
    static const float positions[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, -0.5f, 1, 0, 0, 0.5f, 0};
    static const uint32_t indices[] = {0, 1, 2, 0, 1, 2, 0, 2, 3, 0, 3, 4};
    assert_int_equal(mesh->vertex_count, 5);
    assert_floats(mesh->positions, positions, 15);
    assert_int_equal(mesh->triangle_count, 4);
    assert_memory_equal(mesh->indices, indices, sizeof indices);
    /* sRGB: 188 is half as bright as 255 */
    assert_true(mesh->colors[0] == 1 && fabsf(mesh->colors[1] - 0.5029f) < 1e-3f && mesh->colors[2] == 0);
    assert_true(mesh->colors[3] == 1);
    assert_null(mesh->normals);
    assert_null(mesh->uv[0]);
    assert_true(model.materials[0].def.albedo[0] == 1);
    ty_model_free(&model);
}

/* Some writers end lines by carriage returns. */
static void carriage_returns_end_lines(void** state) {
    (void)state;
    char text[sizeof ascii];
    for (size_t i = 0; i < sizeof ascii; ++i) text[i] = (char)(ascii[i] == '\n' ? '\r' : ascii[i]);
    ty_model model;
    read_well(text, strlen(text), &model);
    assert_int_equal(model.meshes[0].vertex_count, 5);
    assert_int_equal(model.meshes[0].triangle_count, 4);
    ty_model_free(&model);
}

/* Bytes of a binary file being made. */
typedef struct maker {
    uint8_t bytes[4096];
    size_t size;
    bool big;
} maker;

static void put(maker* m, const void* value, size_t size) {
    const uint8_t* from = value;
    for (size_t i = 0; i < size; ++i) m->bytes[m->size + i] = from[m->big ? size - 1 - i : i];
    m->size += size;
}

static void put_header(maker* m, const char* text) {
    memcpy(m->bytes + m->size, text, strlen(text));
    m->size += strlen(text);
}

/* Every type is somewhere in it. */
static void make_binary(maker* m, bool big) {
    static const char elements[] =
        "element other 2\nproperty list ushort short w\nproperty char a\nproperty ushort b\n"
        "element vertex 3\nproperty double x\nproperty double y\nproperty double z\n"
        "property float nx\nproperty float ny\nproperty float nz\nproperty float32 u\nproperty float32 v\n"
        "property float red\nproperty float green\nproperty float blue\nproperty uint8 alpha\n"
        "element face 1\nproperty list uint8 uint32 vertex_index\nproperty list int8 int16 more\nend_header\n";
    *m = (maker){.big = big};
    put_header(m, big ? "ply\nformat binary_big_endian 1.0\n" : "ply\nformat binary_little_endian 1.0\n");
    put_header(m, elements);
    for (uint16_t i = 0; i < 2; ++i) { /* a list of i items, then two numbers */
        put(m, &i, 2);
        for (int16_t k = 0; k < (int16_t)i; ++k) put(m, &k, 2);
        put(m, "x", 1);
        put(m, &i, 2);
    }
    for (int i = 0; i < 3; ++i) {
        const double position[] = {i == 1, i == 2, -1.5};
        const float rest[] = {0, 0, 4, 0.25f, 0.75f, 0.125f * (float)i, 0.5f, 3};
        for (int a = 0; a < 3; ++a) put(m, &position[a], 8);
        for (int k = 0; k < 8; ++k) put(m, &rest[k], 4);
        put(m, &(uint8_t){51}, 1);
    }
    put(m, &(uint8_t){3}, 1);
    for (uint32_t i = 0; i < 3; ++i) put(m, &(uint32_t){2 - i}, 4);
    put(m, &(int8_t){1}, 1);
    put(m, &(int16_t){-1}, 2);
}

static void both_byte_orders_are_read(void** state) {
    (void)state;
    static maker m;
    for (int big = 0; big < 2; ++big) {
        make_binary(&m, big != 0);
        ty_model model;
        read_well(m.bytes, m.size, &model);
        const ty_model_mesh* mesh = &model.meshes[0];
        static const float positions[] = {0, 0, -1.5f, 1, 0, -1.5f, 0, 1, -1.5f};
        static const float normal[] = {0, 0, 1}, uv[] = {0.25f, 0.25f}, color[] = {0.25f, 0.5f, 1, 0.2f};
        static const uint32_t indices[] = {2, 1, 0};
        assert_floats(mesh->positions, positions, 9);
        assert_floats(mesh->normals + 6, normal, 3);
        assert_floats(mesh->uv[0] + 4, uv, 2);
        assert_floats(mesh->colors + 8, color, 4);
        assert_int_equal(mesh->triangle_count, 1);
        assert_memory_equal(mesh->indices, indices, sizeof indices);
        ty_model_free(&model);
    }
}

/* Normals of any length, whose squares single precision cannot hold. */
static void normals_become_unit(void** state) {
    (void)state;
    static const char text[] = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
                               "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
                               "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
                               "0 0 0 3e-40 -4e-40 0\n1 0 0 0 3e30 4e30\n1 1 0 0 0 0\n0 1 0 nan 1 0\n4 0 1 2 3\n";
    static const float normals[] = {0.6f, -0.8f, 0, 0, 0.6f, 0.8f, 0, 0, 0, 0, 0, 0};
    ty_model model;
    read_well(text, strlen(text), &model);
    assert_floats(model.meshes[0].normals, normals, 12);
    ty_model_free(&model);
}

/* Every beginning of a file is refused, and no flipped bit does harm. */
static void torn_files_do_no_harm(void** state) {
    (void)state;
    static maker m;
    make_binary(&m, false);
    for (size_t length = 0; length < m.size; ++length) {
        ty_model model;
        const uint8_t kept = m.bytes[length];
        m.bytes[length] = 0;
        assert_failed(context, read_bytes(m.bytes, length, &model), TY_ERROR_INPUT, "made.ply", NULL);
        ty_model_free(&model);
        m.bytes[length] = kept;
    }
    for (size_t i = 0; i < 8 * m.size; ++i) {
        m.bytes[i / 8] ^= (uint8_t)(1 << i % 8);
        ty_model model;
        const ty_result result = read_bytes(m.bytes, m.size, &model);
        assert_true(result == TY_OK ? model_is_whole(&model) : ty_take_error(context)[0] != '\0');
        ty_model_free(&model);
        m.bytes[i / 8] ^= (uint8_t)(1 << i % 8);
    }
}

static void broken_files_are_refused(void** state) {
    (void)state;
    static const struct {
        const char *part, *by, *message;
    } cases[] = {
        {"ply\n", "plx\n", "not a PLY file"},
        {"ascii 1.0", "ascii 2.0", "made.ply:2: the format is not one of version 1.0"},
        {"ascii 1.0", "text 1.0", "made.ply:2: the format is not ascii"},
        {"format ascii 1.0", "comment", "the header has no format"},
        {"comment made", "remark", "made.ply:3: the header is damaged"},
        {"element vertex 5", "element vertex -5", "made.ply:5: the number of elements is outside"},
        {"element vertex 5", "element vertex 99999999999", "made.ply:5: the number of elements is outside"},
        {"element vertex 5", "element vertex 2000000000", "cut short: no room for 2000000000 vertices"},
        {"element edge 2", "element edge 2000000000", "the data are damaged or cut short"},
        {"element vertex 5", "element vertex", "made.ply:5: the element is damaged"},
        {"element vertex 5\n", "", "made.ply:5: a property without an element"},
        {"element edge 2", "element vertex 2", "made.ply:13: the element is there twice"},
        {"property float x", "property flat x", "made.ply:6: the property has no known type or no name"},
        {"list uchar int ends", "list float int ends", "made.ply:14: the list has no type for its count"},
        {"double y", "double q", "there are no vertices with x, y and z"},
        {"vertex_indices", "corners", "there are no faces with a list vertex_indices"},
        {"end_header\n", "", "the header is damaged"},
        {"-0.5 1 0", "nan 1 0", "vertex 3 is not finite"},
        {"-0.5 1 0", "-0.5 x 0", "the data are damaged or cut short"},
        {"9 3 0 1 2\n", "9 3 0 1 5\n", "a face names vertex 5 of 5"},
        {"9 3 0 1 2\n", "9 3 0 1 -1\n", "a face names vertex -1 of 5"},
        {"9 3 0 1 2\n", "9 3 0 1 1.5\n", "a face names vertex"},
        {"9 3 0 1 2\n", "9 300000000 0 1 2\n", "the data are damaged or cut short"},
        {"9 3 0 1 2\n9 5 0 1 2 3 4\n", "9 0\n9 0\n", "no face has three corners"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        char* text = with_part(ascii, cases[i].part, cases[i].by);
        ty_model model;
        assert_failed(context, read_bytes(text, strlen(text), &model), TY_ERROR_INPUT, "made.ply", cases[i].message);
        ty_model_free(&model);
        free(text);
    }
}

static ty_result read_and_free(ty_context* strict, void* user) {
    ty_model model;
    const maker* m = user;
    const ty_result result = ty_read_ply(strict, "made.ply", m->bytes, m->size, TY_MODEL_ALL, &model);
    ty_model_free(&model);
    return result;
}

static void short_memory_is_survived(void** state) {
    (void)state;
    static maker m;
    make_binary(&m, true);
    strict_memory memory = {.limit = (size_t)1 << 30, .until_refusal = -1};
    ty_context* strict = strict_context(&memory);
    assert_true(check_short_memory(strict, &memory, read_and_free, &m) > 5);
    ty_context_destroy(strict);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(text_is_read),
        cmocka_unit_test(carriage_returns_end_lines),
        cmocka_unit_test(both_byte_orders_are_read),
        cmocka_unit_test(normals_become_unit),
        cmocka_unit_test(torn_files_do_no_harm),
        cmocka_unit_test(broken_files_are_refused),
        cmocka_unit_test(short_memory_is_survived),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
