/* Prints the visibility that a preset of fog leaves over ten metres: the transmittance of green light. */
#include <tyndall/tyndall.h>

#include <math.h>
#include <stdio.h>

int main(void) {
    const ty_context_def def = ty_default_context_def();
    ty_context* context = NULL;
    ty_medium_def fog = ty_default_medium_def();
    ty_result result = ty_context_create(&def, &context);
    if (result == TY_OK) result = ty_medium_parse(context, "fog:50", &fog);
    if (result == TY_OK) printf("transmittance %.3f\n", exp(-10 * (double)(fog.sigma_s[1] + fog.sigma_a[1])));
    if (result != TY_OK) fprintf(stderr, "%s: %s\n", ty_result_name(result), ty_take_error(context));
    ty_context_destroy(context);
    return result == TY_OK ? 0 : 1;
}
