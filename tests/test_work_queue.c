/* Tasks among ranks that are threads of this program, with mailboxes in place of MPI: images and bakes are
 * those of one rank, and blocks are handed out once. */
#include "bake/receivers/distributed.h"
#include "base/context.h"
#include "checks.h"
#include "comm/blocks.h"
#include "method/path/distributed.h"
#include "ranks.h"

enum { RANKS = 3 };

/* ---- ranks ---- */

static ty_scene* load(ty_context* context) {
    const char* const overrides[] = {"camera.resolution=[40, 25]"};
    ty_scene* scene = NULL;
    assert_int_equal(ty_scene_load(context, "builtin:cornell_fog", overrides, 1, &scene), TY_OK);
    return scene;
}

/* The task of a rank other than 0. */
typedef struct helping {
    int32_t rank;
    const char* text; /* of its greeting */
} helping;

static void* help(void* user) {
    const helping* told = user;
    own_rank = told->rank;
    ty_context* context = make_context(2);
    ty_scene* scene = load(context);
    ty_comm* comm = NULL;
    ty_path_helper paths = {.scene = scene};
    ty_bake_helper bakes = {.scene = scene};
    const ty_job_worker workers[TY_JOB_KINDS] = {
        [TY_JOB_PATH] = ty_path_job_worker(&paths), [TY_JOB_BAKE] = ty_bake_job_worker(&bakes)};
    if (ty_comm_join(&box_backend, 10, told->rank, &comm) == TY_OK) {
        ty_queue_hello(comm, 0, told->text);
        bool together = false;
        if (ty_queue_serve(comm, workers, NULL, &together) != 3 || !together) abort();
        ty_comm_close(comm, true, 0);
    }
    ty_scene_destroy(scene);
    ty_context_destroy(context);
    return NULL;
}

/* Rank 0 and its helpers. */
typedef struct ranks {
    ty_context* context;
    ty_scene* scene;
    ty_comm* comm;
    ty_work_queue* queue;
    helping told[RANKS];
    pthread_t threads[RANKS];
} ranks;

static void begin_ranks(ranks* all, const char* text_of_last) {
    mailbox* own = &box_messages[0];
    for (; own->count > 0; --own->count) free(own->letters[own->count - 1].bytes); /* a greeting that nobody read */
    box_ranks = RANKS;
    *all = (ranks){.context = make_context(2)};
    all->scene = load(all->context);
    assert_int_equal(ty_comm_join(&box_backend, 10, 0, &all->comm), TY_OK);
    assert_int_equal(ty_comm_size(all->comm), RANKS);
    all->queue = ty_queue_create(all->comm);
    assert_non_null(all->queue);
    for (int32_t i = 1; i < RANKS; ++i) {
        all->told[i] = (helping){i, i == RANKS - 1 ? text_of_last : "the same"};
        assert_int_equal(pthread_create(&all->threads[i], NULL, help, &all->told[i]), 0);
    }
}

static void end_ranks(ranks* all) {
    ty_context_set_queue(all->context, NULL);
    assert_true(ty_queue_destroy(all->queue, 3));
    for (int i = 1; i < RANKS; ++i) pthread_join(all->threads[i], NULL);
    ty_comm_close(all->comm, true, 0);
    ty_scene_destroy(all->scene);
    ty_context_destroy(all->context);
}

static void greet(ranks* all) {
    char message[256] = "";
    assert_true(ty_queue_greet(all->queue, "the same", 60, message, sizeof message));
    ty_context_set_queue(all->context, all->queue);
}

/* ---- tests ---- */

static void assert_same_images(const ty_image* a, const ty_image* b) {
    const size_t bytes = sizeof(float) * (size_t)ty_image_width(a) * (size_t)ty_image_height(a);
    assert_int_equal(ty_image_channel_count(a), ty_image_channel_count(b));
    for (int32_t c = 0; c < ty_image_channel_count(a); ++c)
        assert_memory_equal(ty_image_plane_const(a, c), ty_image_plane_const(b, c), bytes);
}

/* aovs with halves send all that a block has; an error bound has short passes. */
static void images_of_ranks_are_those_of_one(void** state) {
    (void)state;
    ranks all;
    begin_ranks(&all, "the same");
    greet(&all);
    const uint32_t aovs[] = {TY_AOV_VARIANCE, TY_AOV_DEPTH | TY_AOV_SINGLE | TY_AOV_HALF, TY_AOV_VARIANCE};
    for (int i = 0; i < 3; ++i) {
        ty_path_def def = ty_default_path_def();
        ty_image *shared = NULL, *alone = NULL;
        ty_path_stats of_shared = ty_default_path_stats(), of_alone = ty_default_path_stats();
        def.spp = i == 2 ? 64 : 6;
        def.error = i == 2 ? 0.5 : 0;
        def.aovs = aovs[i];
        assert_int_equal(ty_path_render(all.scene, &def, &shared, &of_shared), TY_OK);
        ty_context_set_queue(all.context, NULL);
        assert_int_equal(ty_path_render(all.scene, &def, &alone, &of_alone), TY_OK);
        ty_context_set_queue(all.context, all.queue);
        assert_same_images(shared, alone);
        assert_true(of_shared.paths == of_alone.paths && of_shared.vertices == of_alone.vertices);
        ty_image_destroy(shared);
        ty_image_destroy(alone);
    }
    assert_true(ty_comm_get_traffic(all.comm).bytes > 40 * 25 * 48);
    end_ranks(&all);
}

static void bakes_of_ranks_are_those_of_one(void** state) {
    (void)state;
    enum { COUNT = 60 };
    static float positions[3 * COUNT];
    static ty_bake_probe shared[COUNT], alone[COUNT];
    ranks all;
    begin_ranks(&all, "the same");
    greet(&all);
    uint64_t seed = 5;
    for (int i = 0; i < 3 * COUNT; ++i) positions[i] = (float)(0.3 + 0.4 * uniform(&seed));
    ty_bake_def def = ty_default_bake_def();
    def.method = TY_BAKE_SURFACES;
    def.spp = 40; /* two passes */
    assert_int_equal(ty_bake_probes(all.scene, &def, positions, COUNT, shared, NULL), TY_OK);
    ty_context_set_queue(all.context, NULL);
    assert_int_equal(ty_bake_probes(all.scene, &def, positions, COUNT, alone, NULL), TY_OK);
    assert_memory_equal(shared, alone, sizeof shared);
    end_ranks(&all);
}

static void a_rank_with_other_files_is_named(void** state) {
    (void)state;
    ranks all;
    char message[256] = "";
    begin_ranks(&all, "another");
    assert_false(ty_queue_greet(all.queue, "the same", 60, message, sizeof message));
    assert_non_null(strstr(message, "rank 2 on "));
    assert_non_null(strstr(message, "(another, not the same)"));
    end_ranks(&all);
}

static void blocks_are_taken_once(void** state) {
    (void)state;
    ty_blocks blocks = {0};
    int64_t first = -1;
    assert_true(ty_blocks_create(&blocks, 10));
    assert_true(ty_blocks_take(&blocks, 0));
    assert_false(ty_blocks_take(&blocks, 0));
    assert_int_equal(ty_blocks_lend(&blocks, 4, 1, &first), 4); /* half of nine at most */
    assert_int_equal(first, 6);
    assert_false(ty_blocks_take(&blocks, 7));
    assert_int_equal(ty_blocks_lend(&blocks, 4, 8, &first), 1); /* at least one */
    assert_int_equal(first, 5);
    assert_int_equal(atomic_load(&blocks.away), 5);
    assert_true(ty_blocks_return(&blocks, 6));
    ty_blocks_settle(&blocks);
    assert_false(ty_blocks_return(&blocks, 6));
    assert_false(ty_blocks_take_back(&blocks, 6));
    assert_true(ty_blocks_take_back(&blocks, 7)); /* and what its rank returns then is of no use */
    assert_false(ty_blocks_return(&blocks, 7));
    assert_int_equal(atomic_load(&blocks.away), 3);
    for (int64_t b = 1; b < 5; ++b) assert_true(ty_blocks_take(&blocks, b));
    assert_int_equal(ty_blocks_lend(&blocks, 1, 1, &first), 0);
    ty_blocks_reset(&blocks);
    assert_true(ty_blocks_take(&blocks, 6));
    ty_blocks_destroy(&blocks);
}

static void one_process_is_alone(void** state) {
    (void)state;
    ty_comm* comm = (ty_comm*)state;
    assert_int_equal(ty_comm_open("nowhere.so", 1, &comm), TY_OK);
    assert_null(comm);
    assert_int_equal(ty_comm_rank(NULL), 0);
    assert_int_equal(ty_comm_size(NULL), 1);
    assert_int_equal(ty_comm_get_traffic(NULL).messages, 0);
    ty_comm_close(NULL, true, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(images_of_ranks_are_those_of_one),
        cmocka_unit_test(bakes_of_ranks_are_those_of_one),
        cmocka_unit_test(a_rank_with_other_files_is_named),
        cmocka_unit_test(blocks_are_taken_once),
        cmocka_unit_test(one_process_is_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
