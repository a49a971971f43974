/* Timings of papers, measured by the code of the benches: for figures. */
#ifndef TY_BENCH_TABLES_H
#define TY_BENCH_TABLES_H

#include "bench/bench.h"

enum { BENCH_TABLE_ROWS = 12, BENCH_TABLE_COLUMNS = 6, BENCH_TABLE_TITLE = 48 };

typedef struct bench_table {
    int rows, columns, paper_columns;
    const char *row_names[BENCH_TABLE_ROWS], *units[BENCH_TABLE_ROWS];
    char titles[BENCH_TABLE_COLUMNS][BENCH_TABLE_TITLE];       /* columns of measured */
    char paper_titles[BENCH_TABLE_COLUMNS][BENCH_TABLE_TITLE]; /* columns of paper */
    double measured[BENCH_TABLE_ROWS][BENCH_TABLE_COLUMNS];    /* medians */
    double paper[BENCH_TABLE_ROWS][BENCH_TABLE_COLUMNS];       /* 0: not given */
    const char* paper_machine;
    char setting[256]; /* the test case */
} bench_table;

/* Table 1 of light propagation volumes: injection and propagation. */
ty_result bench_lpv_table(const bench_session* bench, bench_table* out);
/* Times of principal-ordinates propagation in the paper's typical setting (Fig. 14). */
ty_result bench_pop_table(const bench_session* bench, bench_table* out);
/* Overhead of media over surfaces (impulse responses, Section 5). */
ty_result bench_bake_table(const bench_session* bench, bench_table* out);

/* Table 1 of screen-space scattering: median seconds of the steps and of all, of scatter with filters of 2, 4 and 6
 * pixels, gather with 4, naive with 4, gather with 2 and 6. */
enum { BENCH_SCREEN_CASES = 7 };
typedef struct bench_screen_time {
    const char* name; /* "scatter 2x2" */
    double step[3], total;
} bench_screen_time;

ty_result bench_screen_times(ty_context* context, const int32_t size[2], int runs,
                             bench_screen_time out[BENCH_SCREEN_CASES]);

#endif
