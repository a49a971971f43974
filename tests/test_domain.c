/* Transfers between ranks, calls of all of them, and grids cut into boxes, with ranks that are threads of this program.
 */
#include "checks.h"
#include "comm/domain.h"
#include "comm/joint.h"
#include "ranks.h"

/* ---- transfers ---- */

/* Every rank sends many small messages to every other, of two tags, before it reads any. */
static void send_many(ty_comm* comm, void* user) {
    (void)user;
    const int32_t size = ty_comm_size(comm), rank = ty_comm_rank(comm);
    for (int32_t i = 0; i < 50; ++i)
        for (int32_t to = 0; to < size; ++to) {
            const int32_t text[2] = {1000 * rank + i, to};
            if (to != rank) require(ty_comm_put(comm, to, i & 1, text, sizeof text));
        }
    for (int32_t tag = 1; tag >= 0; --tag)
        for (int32_t from = size - 1; from >= 0; --from)
            for (int32_t i = tag; i < 50 && from != rank; i += 2) {
                int32_t text[2];
                require(ty_comm_get(comm, from, tag, text, sizeof text));
                require(text[0] == 1000 * from + i && text[1] == rank);
            }
    if (comm != NULL) require(ty_comm_get_traffic(comm).messages == 100 * (uint64_t)(size - 1));
}

/* Sums of values that depend on the order of addition, parts of different sizes, and bytes of rank 0. */
static void combine_all(ty_comm* comm, void* user) {
    (void)user;
    const int32_t size = ty_comm_size(comm), rank = ty_comm_rank(comm);
    static const double terms[RANKS_MAX] = {1, 1e-16, 1e-16, -1, 1e16, 3, -1e16, 0.5};
    double sum = 0, max = terms[0], values[2] = {terms[rank], rank}, maxima[1] = {terms[rank]};
    for (int32_t r = 0; r < size; ++r) {
        sum = r == 0 ? terms[0] : sum + terms[r];
        max = terms[r] > max ? terms[r] : max;
    }
    require(ty_comm_sum(comm, values, 2) && values[0] == sum && values[1] == 0.5 * size * (size - 1));
    require(ty_comm_max(comm, maxima, 1) && maxima[0] == max);
    size_t offsets[RANKS_MAX + 1] = {0};
    for (int32_t r = 0; r < size; ++r) offsets[r + 1] = offsets[r] + (size_t)(3 * r); /* nothing of rank 0 */
    uint8_t all[3 * RANKS_MAX * RANKS_MAX] = {0}, gathered[sizeof all] = {0}, told[5] = {0};
    memset(all + offsets[rank], rank + 1, offsets[rank + 1] - offsets[rank]);
    memcpy(gathered, all, sizeof all);
    require(ty_comm_gather_all(comm, all, offsets) && ty_comm_gather(comm, gathered, offsets));
    for (int32_t r = 0; r < size; ++r)
        for (size_t i = offsets[r]; i < offsets[r + 1]; ++i)
            require(all[i] == r + 1 && (rank > 0 || gathered[i] == r + 1));
    if (rank == 0) memcpy(told, "told", sizeof told);
    require(ty_comm_broadcast(comm, told, sizeof told) && strcmp((const char*)told, "told") == 0);
}

static void transfers_arrive(void** state) {
    (void)state;
    for (int32_t ranks = 1; ranks <= RANKS_MAX; ++ranks) {
        run_ranks(ranks, send_many, NULL);
        run_ranks(ranks, combine_all, NULL);
    }
}

/* The last rank leaves without a word. */
static void miss_one(ty_comm* comm, void* user) {
    (void)user;
    const int32_t last = ty_comm_size(comm) - 1;
    int32_t word = 0;
    if (ty_comm_rank(comm) == last) return;
    require(!ty_comm_get(comm, last, 0, &word, sizeof word));
    require(ty_comm_lost(comm) == last);
    require(!ty_comm_broadcast(comm, &word, sizeof word)); /* at once */
}

static void a_rank_that_does_not_answer_is_named(void** state) {
    (void)state;
    run_ranks_for(3, 0.02, miss_one, NULL);
}

/* ---- boxes ---- */

static void grids_are_cut_where_it_costs_least(void** state) {
    (void)state;
    const struct {
        int32_t cells[3], ranks;
        unsigned cuts;
        int32_t expected[3];
    } cases[] = {
        {{64, 64, 64}, 2, TY_CUT_X | TY_CUT_Y | TY_CUT_Z, {1, 1, 2}},
        {{64, 64, 64}, 4, TY_CUT_X | TY_CUT_Y | TY_CUT_Z, {1, 2, 2}},
        {{64, 64, 64}, 8, TY_CUT_X | TY_CUT_Y | TY_CUT_Z, {2, 2, 2}},
        {{64, 64, 64}, 4, TY_CUT_X | TY_CUT_Y, {2, 2, 1}},
        {{64, 16, 8}, 4, TY_CUT_X | TY_CUT_Y | TY_CUT_Z, {4, 1, 1}},
        {{64, 64, 64}, 3, TY_CUT_Y | TY_CUT_Z, {1, 1, 3}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        static ty_comm* const none = NULL;
        const int32_t unit[3] = {1, 1, 1};
        ty_domain domain;
        box_ranks = cases[i].ranks;
        ty_comm* comm = none;
        assert_int_equal(ty_comm_join(&box_backend, 1, 0, &comm), TY_OK);
        assert_true(ty_domain_create(comm, cases[i].cells, cases[i].cuts, unit, 2, &domain));
        assert_memory_equal(domain.ranks, cases[i].expected, sizeof domain.ranks);
        /* Boxes of at least a half of the grid, and none that may be cut. */
        assert_false(ty_domain_create(comm, cases[i].cells, cases[i].cuts, unit, 65, &domain));
        assert_false(ty_domain_create(comm, cases[i].cells, 0, unit, 1, &domain));
        ty_comm_close(comm, true, 0);
    }
}

/* Boxes of all ranks are the grid, begin at multiples of the unit, and have the cells around them afterwards. */
static void check_boxes(ty_comm* comm, void* user) {
    const int32_t* cells = user;
    const int32_t unit[3] = {1, 2, 4};
    ty_domain d;
    require(ty_domain_create(comm, cells, TY_CUT_X | TY_CUT_Y | TY_CUT_Z, unit, 2, &d));
    int32_t size[3];
    double share = 1;
    for (int axis = 0; axis < 3; ++axis) {
        size[axis] = d.end[axis] - d.first[axis];
        share *= size[axis];
        require(size[axis] >= 2 && d.first[axis] % unit[axis] == 0);
        require(ty_domain_first(&d, axis, 0) == 0 && ty_domain_first(&d, axis, d.ranks[axis]) == cells[axis]);
    }
    require(ty_comm_sum(comm, &share, 1) && (int64_t)share == (int64_t)cells[0] * cells[1] * cells[2]);
    const ptrdiff_t row = size[0] + 2, plane = row * (size[1] + 2), items = plane * (size[2] + 2);
    float* values = calloc((size_t)items, sizeof *values);
    double* pairs = calloc(2 * (size_t)items, sizeof *pairs); /* every other item */
    require(values != NULL && pairs != NULL);
    float* origin = values + plane + row + 1;
    double* wide = pairs + 2 * (plane + row + 1);
#define NUMBER(x, y, z) (1 + (d.first[0] + (x)) + 100 * (d.first[1] + (y)) + 10000 * (d.first[2] + (z)))
    for (int32_t z = 0; z < size[2]; ++z)
        for (int32_t y = 0; y < size[1]; ++y)
            for (int32_t x = 0; x < size[0]; ++x) {
                origin[x + row * y + plane * z] = (float)NUMBER(x, y, z);
                wide[2 * (x + row * y + plane * z)] = NUMBER(x, y, z);
            }
    const ty_halo halos[2] = {{origin, sizeof(float), {1, row, plane}},
                              {wide, sizeof(double), {2, 2 * row, 2 * plane}}};
    require(ty_domain_exchange(&d, size, halos, 2));
    for (int32_t z = -1; z <= size[2]; ++z)
        for (int32_t y = -1; y <= size[1]; ++y)
            for (int32_t x = -1; x <= size[0]; ++x) {
                const int32_t at[3] = {d.first[0] + x, d.first[1] + y, d.first[2] + z};
                bool inside = true;
                for (int a = 0; a < 3; ++a) inside = inside && at[a] >= 0 && at[a] < cells[a];
                const int32_t expected = inside ? NUMBER(x, y, z) : 0;
                require((int32_t)origin[x + row * y + plane * z] == expected);
                require((int32_t)wide[2 * (x + row * y + plane * z)] == expected);
            }
#undef NUMBER
    require((ty_comm_size(comm) > 1) == (d.halos.messages > 0));
    free(values);
    free(pairs);
    ty_domain_destroy(&d);
}

static void boxes_know_their_neighbours(void** state) {
    (void)state;
    int32_t grids[][3] = {{16, 10, 14}, {33, 9, 21}};
    for (int g = 0; g < 2; ++g)
        for (int32_t ranks = 1; ranks <= RANKS_MAX; ++ranks) run_ranks(ranks, check_boxes, grids[g]);
}

/* ---- joint solves ---- */

/* The sum of a number of rank 0 and the ranks, which every rank makes. */
static double add_up(ty_comm* comm, double number) {
    double sum = number + ty_comm_rank(comm);
    require(ty_comm_sum(comm, &sum, 1));
    return sum;
}

static void take_part(ty_comm* comm, void* user, const uint8_t* bytes, size_t size) {
    double number, *out = user;
    require(size == sizeof number);
    memcpy(&number, bytes, sizeof number);
    *out += add_up(comm, number);
}

/* Two solves, and one of a kind that the others do not know. */
static void solve_twice(ty_comm* comm, void* user) {
    double sum = 0;
    bool all = false;
    char message[128];
    (void)user;
    if (ty_comm_rank(comm) > 0) {
        const ty_joint_solver solvers[TY_JOINT_KINDS] = {[TY_JOINT_DIFFUSION] = take_part};
        ty_joint_rank rank = {comm, solvers, &sum};
        const ty_job_worker workers[TY_JOB_KINDS] = {[TY_JOB_JOINT] = ty_joint_job_worker(&rank)};
        ty_queue_hello(comm, 0, "");
        require(ty_queue_serve(comm, workers, NULL, &all) == 0 && all);
        require(sum == 3 * (1 + 2) + 2 * (0 + 1 + 2));
        return;
    }
    ty_work_queue* queue = ty_queue_create(comm);
    require(queue != NULL && ty_queue_greet(queue, "", 10, message, sizeof message));
    for (int i = 0; i < 2; ++i) {
        const double number = 1 + i;
        require(ty_joint_begin(queue, TY_JOINT_DIFFUSION, &number, sizeof number) == comm);
        require(add_up(comm, number) == 3 * number + 3);
        require(ty_joint_begin(queue, TY_JOINT_ORDINATES, &number, sizeof number) == NULL);
    }
    require(ty_queue_destroy(queue, 0));
}

static void ranks_solve_together(void** state) {
    (void)state;
    assert_null(ty_joint_begin(NULL, TY_JOINT_DIFFUSION, NULL, 0));
    run_ranks(3, solve_twice, NULL);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(transfers_arrive),
        cmocka_unit_test(a_rank_that_does_not_answer_is_named),
        cmocka_unit_test(grids_are_cut_where_it_costs_least),
        cmocka_unit_test(boxes_know_their_neighbours),
        cmocka_unit_test(ranks_solve_together),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
