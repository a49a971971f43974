/* The long form of truth_reference.c: with our own noise well below that of the references. */
#include "truth_cases.h"

static void test_cube_g0(void** state) {
    check_reference(*state, "cube_g0", 0.005, 0.006, 1024);
}

static void test_cube_g07(void** state) {
    check_reference(*state, "cube_g0.7", 0.005, 0.01, 2048);
}

static void test_cube_g096(void** state) {
    check_reference(*state, "cube_g0.96", 0.02, 0, 4096);
}

static void test_cornell(void** state) {
    check_reference(*state, "cornell_gray", 0.005, 0.01, 1024);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_cube_g0),
        cmocka_unit_test(test_cube_g07),
        cmocka_unit_test(test_cube_g096),
        cmocka_unit_test(test_cornell),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
