/* Scene files whose volumes are scans and microscopy stacks: DICOM series by folder or file, NIfTI, TIFF, Mitsuba's
 * grids; changes of their files. */
#include "dicom_maker.h"
#include "mesh_maker.h"

#include "scene/scene.h"

#include <math.h>
#include <sys/stat.h>
#include <tyndall/io.h>

#define HEAD "{'tyndall':1,'meters_per_unit':0.001,"

static log_book book;
static ty_context* context;
static dicom_writer writer;

static void put_slice(const char* path, const char* series, const char* position, int64_t first) {
    dicom_form form = dicom_default_form();
    int64_t samples[6];
    for (int i = 0; i < 6; ++i) samples[i] = first + i;
    form.series = series;
    form.intercept = "-1024";
    dicom_slice(&writer, &form, position);
    dicom_pixels(&writer, &form, samples);
    put_file(path, writer.bytes, writer.size);
}

static int start(void** state) {
    (void)state;
    context = logged_context(&book, 2);
    mkdir("head", 0777);
    mkdir("both", 0777);
    put_slice("head/IM1", "1.2.3", "0\\0\\2", 2000);
    put_slice("head/IM2", "1.2.3", "0\\0\\0", 1000);
    put_slice("both/a", "1.2.4", "0\\0\\0", 1);
    put_slice("both/b", "1.2.5", "0\\0\\0", 2);
    return 0;
}

static int stop(void** state) {
    (void)state;
    ty_context_destroy(context);
    return 0;
}

static ty_result parse(const char* text, ty_scene** scene) {
    const char* json = quoted(text);
    return ty_scene_parse(context, json, strlen(json), "s.json", "", NULL, 0, scene);
}

static ty_grid_info density_of(const char* text, uint64_t* hash) {
    ty_scene* scene = NULL;
    ty_medium_def medium;
    if (parse(text, &scene) != TY_OK) fail_msg("%s", ty_take_error(context));
    assert_int_equal(ty_scene_get_medium(scene, 0, &medium), TY_OK);
    const ty_grid_info info = ty_grid_get_info(medium.density_grid);
    *hash = ty_scene_hash(scene);
    ty_scene_destroy(scene);
    return info;
}

static void refuse(const char* text, const char* words) {
    ty_scene* scene = NULL;
    assert_int_equal(parse(text, &scene), TY_ERROR_INPUT);
    const char* message = ty_take_error(context);
    if (strncmp(message, "s.json:1: media[0].density", 26) != 0 || strstr(message, words) == NULL)
        fail_msg("\"%s\" does not say \"%s\"", message, words);
}

/* A folder, or a file of it without an extension, is a series; Hounsfield units go through a transfer function. */
static void series_are_volumes(void** state) {
    (void)state;
    static const char* const scenes[] = {
        HEAD "'media':[{'sigma_t':1,'density':{'file':'head'},'transfer':[{'value':-24,'density':0,'albedo':1},"
             "{'value':976,'density':4,'albedo':0.5}]}]}",
        HEAD "'media':[{'sigma_t':1,'density':{'file':'head/IM1'},'transfer':[{'value':-24,'density':0,'albedo':1},"
             "{'value':976,'density':4,'albedo':0.5}]}]}"};
    for (int i = 0; i < 2; ++i) {
        uint64_t hash;
        const ty_grid_info info = density_of(scenes[i], &hash);
        assert_int_equal(info.size[2], 2);
        assert_true(info.min == 1000 - 1024 && info.max == 2005 - 1024);
        assert_true(info.placed);
    }
}

static void changes_of_slices_are_seen(void** state) {
    (void)state;
    static const char* const scenes[] = {HEAD "'media':[{'sigma_s':1,'density':{'file':'head'}}]}",
                                         HEAD "'media':[{'sigma_s':1,'density':{'file':'head/IM2'}}]}"};
    for (int i = 0; i < 2; ++i) {
        uint64_t before, after, again;
        const ty_grid_info info = density_of(scenes[i], &before);
        put_slice("head/IM1", "1.2.3", "0\\0\\2", 2500 + i);
        assert_true(density_of(scenes[i], &after).max == info.max + (i == 0 ? 500 : 1));
        assert_true(before != after);
        put_file("head/notes.txt", "no slice", 8); /* other files do not matter */
        density_of(scenes[i], &again);
        assert_true(after == again);
    }
}

static void one_of_several_series_is_chosen(void** state) {
    (void)state;
    uint64_t hash;
    refuse(HEAD "'media':[{'sigma_s':1,'density':{'file':'both'}}]}", "2 series, of which one must be chosen");
    refuse(HEAD "'media':[{'sigma_s':1,'density':{'file':'both','series':'7'}}]}", "no series \"7\"");
    const ty_grid_info info = density_of(HEAD "'media':[{'sigma_s':1,'density':{'file':'both','series':'5'}}]}", &hash);
    assert_true(info.max == 2 + 5 - 1024);
    put_file("a.vol", "VOL\3", 4);
    refuse(HEAD "'media':[{'sigma_s':1,'density':{'file':'a.vol','series':'5'}}]}",
           "is for folders and files of DICOM");
    refuse(HEAD "'media':[{'sigma_s':1,'density':{'file':'a.vol'}}]}", "cut short in its header");
    refuse(HEAD "'media':[{'sigma_s':1,'density':{'file':'head','raw':{'size':[1,1,1]}}}]}", "is for raw files");
    refuse(HEAD "'media':[{'sigma_s':1,'density':{'file':'head','grid':'density'}}]}",
           "is for .vdb, .nvdb, .vti, .vtk and .nc files");
    put_file("plain", "x", 1);
    refuse(HEAD "'media':[{'sigma_s':1,'density':{'file':'plain'}}]}", "cannot read volumes of this type");
}

/* The voxels of a NIfTI pair, in a file that the header does not name. */
static void pairs_are_hashed(void** state) {
    (void)state;
    static const uint8_t sizes[16] = {3, 0, 2, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0};
    uint8_t header[348] = {92, 1};
    memcpy(header + 40, sizes, sizeof sizes);
    header[70] = 2; /* uint8 */
    memcpy(header + 344, "ni1", 4);
    put_file("pair.hdr", header, sizeof header);
    put_file("pair.img", "\1\2", 2);
    uint64_t before, after;
    const char* scene = HEAD "'media':[{'sigma_s':1,'density':{'file':'pair.hdr'}}]}";
    assert_true(density_of(scene, &before).max == 2);
    put_file("pair.img", "\1\3", 2);
    assert_true(density_of(scene, &after).max == 3);
    assert_true(before != after);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(series_are_volumes),
        cmocka_unit_test(changes_of_slices_are_seen),
        cmocka_unit_test(one_of_several_series_is_chosen),
        cmocka_unit_test(pairs_are_hashed),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
